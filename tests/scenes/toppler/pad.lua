-- Appended to games/toppler/main.lua by test_games: a gamepad's buttons start a level, end the flight over it, aim, throw, and go back.

local update = daft.update
local yaw

local STEPS = {
    [10] = { "pad a", true }, [12] = { "pad a", false },             -- Play
    [60] = { "pad a", true }, [62] = { "pad a", false },             -- enough of the flight
    [70] = { "pad right", true }, [90] = { "pad right", false },
    [100] = { "pad a", true }, [102] = { "pad a", false },           -- a tap throws nothing
    [120] = { "pad a", true }, [160] = { "pad a", false },
    [260] = { "pad b", true }, [262] = { "pad b", false },
}

function daft.update(dt)
    local step = STEPS[daft.tick()]
    if step then daft.input.set(step[1], step[2]) end
    update(dt)
    if daft.tick() == 5 then assert(game.state == "title" and menus.shown()) end
    if daft.tick() == 50 then assert(game.state == "fly" and game.number == 1 and not menus.shown()) end
    if daft.tick() == 68 then
        assert(game.state == "aim")
        yaw = catapult.yaw
    end
    if daft.tick() == 95 then assert(catapult.yaw > yaw + 0.01) end
    if daft.tick() == 115 then assert(game.state == "aim" and game.shot == 1) end
    if daft.tick() == 180 then assert(game.state == "watch" and math.abs(game.last_pull - 40 / 90) < 0.03 and game.ball:valid()) end
    if daft.tick() == 270 then
        assert(game.state == "title" and menus.shown())
        print("the gamepad plays")
        daft.quit()
    end
end
