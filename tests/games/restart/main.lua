-- Restart: after daft.restart everything is as at first; after daft.quit nothing more is called.
assert(daft.tick() == 0 and leftover == nil)
leftover = daft.random(1000000)
local first = leftover

function daft.update()
    assert(daft.tick() <= 30)
    if daft.tick() == 10 and not daft.input.down("space") then
        daft.input.set("space", true)
        daft.entity { sphere = 1 }
    end
    if daft.tick() == 11 and daft.input.pressed("space") then
        print("first", first)
        daft.restart()
    end
    if daft.tick() == 30 then
        print("second", first)
        daft.quit()
    end
end
