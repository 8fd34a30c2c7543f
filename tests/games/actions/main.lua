-- Actions: what they are worth, when they go down and up; letters that are typed. Keys are pressed by the game itself,
-- or by a test at a window.

typed = ""

function daft.load()
    daft.input.bind("jump", "space", "pad a", "right trigger")
    daft.input.bind("walk", "right", "-left", "left x")
    daft.input.text(true)
    local function wrong(message, ...)
        local good, text = pcall(daft.input.bind, ...)
        assert(not good and text:find(message, 1, true), text)
    end
    wrong("'space' is a key", "space", "a")
    wrong("there is no key or stick 'spcae': did you mean 'space'?", "fire", "spcae")
    wrong("there is no key or stick '-lefft'", "fire", "-lefft")
    wrong("1 to 8 inputs expected, got 0", "fire")
    local good, text = pcall(daft.input.action, "wlak")
    assert(not good and text:find("there is no action 'wlak': did you mean 'walk'?", 1, true), text)
    assert(not pcall(daft.input.rumble, 2, 1))
    daft.input.rumble(0.5, 0.2)
end

function daft.textinput(letter)
    typed = typed .. letter
    print("typed " .. typed)
end

local steps = {
    [2] = function() daft.input.set("space", true) end,
    [3] = function() assert(daft.input.down("jump") and daft.input.pressed("jump") and daft.input.action("jump") == 1) end,
    [4] = function() assert(daft.input.down("jump") and not daft.input.pressed("jump")) daft.input.set("space", false) end,
    [5] = function() assert(not daft.input.down("jump") and daft.input.released("jump")) daft.input.set("left", true) end,
    [6] = function() assert(daft.input.action("walk") == -1 and not daft.input.released("jump")) daft.input.set("right", true) end,
    [7] = function() assert(daft.input.action("walk") == 0 and daft.input.down("walk")) end,
}

function daft.update()
    local step = steps[daft.tick() - 50] -- later than any test at a window
    if step then step() end
end

function daft.draw()
    if daft.tick() == 58 then -- headless, and later than any test at a window
        assert(daft.input.label("left shift") == "Left Shift" and daft.input.label("q") == "Q")
        assert(daft.input.label("left x") == "left stick ← →" and daft.input.label("-left y") == "left stick up")
        assert(daft.input.label("mouse1") == "left mouse button" and daft.input.label("pad a") == "pad a")
        assert(daft.input.label("walk") == "Right" and not pcall(daft.input.label, "wlak"))
    end
    daft.text("jump: " .. (daft.input.key_of("jump") or "nothing") .. ", " .. typed, 16, 16)
end
