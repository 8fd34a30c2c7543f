-- Letters: texts in 3D are shared while they are held, and mistakes say what is wrong.
local kept

local function fails(t, wanted)
    local ok, message = pcall(daft.mesh, t)
    assert(not ok and message:find(wanted, 1, true), message)
end

function daft.load()
    local a = daft.mesh { text = "AB", size = 2, depth = 0.5 }
    assert(a == daft.mesh { text = "AB", size = 2, depth = 0.5 })
    assert(a ~= daft.mesh { text = "AB", size = 2, depth = 0.4 })
    assert(a ~= daft.mesh { text = "AB", size = 2, depth = 0.5, align = "left" })
    local low, high = a:bounds()
    assert(low[3] == -0.25 and high[3] == 0.25 and math.abs(high[2] - 2) < 0.02)
    kept = a
    fails({ text = "" }, "text: something to see expected")
    fails({ text = " \n " }, "text: something to see expected")
    fails({ text = ("x"):rep(513) }, "512 bytes at most")
    fails({ text = "x", size = 0 }, "size: number from 0.001 to 10000 expected")
    fails({ text = "x", dept = 1 }, "did you mean 'depth'")
end

-- So many that collections come in between.
function daft.update()
    for i = 1, 1000 do daft.mesh { text = i, size = 1 } end
    assert(kept == daft.mesh { text = "AB", size = 2, depth = 0.5 })
end
