-- The ten levels as data and building plans. Metres; the catapult stands at the origin and throws along x.
--   shots: what lies beside the catapult, in order.  par: how many of them earn three stars.
--   view: the middle of what there is to see, and how wide it is: for the cameras.
--   build(b): builds it of blocks.lua.

local pi = math.pi

-- A straight run of dominoes, or a bend; `heading` is the way they fall. Both give where the next one stands.
local function dominoes(b, x, z, heading, count, turn)
    local colors = { "red", "yellow", "green", "blue" }
    local gap = 0.78
    for i = 1, count do
        heading = heading + (turn or 0)
        b.add(colors[i % #colors + 1], x, 0.85, z, { 0.3, 1.7, 0.85 }, { heading, 0, 0 })
        x, z = x + gap * math.cos(heading + (turn or 0) / 2), z + gap * math.sin(heading + (turn or 0) / 2)
    end
    return x, z
end

local function knock(b)
    for _, z in ipairs { -2.4, 2.4 } do b.column({ "red", "white" }, 24, z, 5, { 0.7, 0.5, 0.7 }) end
    b.king(24, b.column({ "blue", "yellow", "red" }, 24, 0, 3, { 1.1, 1, 1.1 }), 0)
end

local function cards(b)
    b.king(22, b.cards(22, 0, 5, 2), 0)
end

local function birds(b)
    local top = b.column({ "white", "blue" }, 25, 0, 5, { 1.1, 0.8, 1.1 })
    b.add("wood", 25, top + 0.15, 0, { 1.2, 0.3, 8 })
    b.king(25, top + 0.3, -3.4)
    b.king(25, top + 0.3, 3.4)
end

local function fall_in_line(b)
    local x, z = dominoes(b, 14, -8, 0, 8)
    x, z = dominoes(b, x, z, 0, 9, pi / 18)
    x, z = dominoes(b, x, z, pi / 2, 6)
    b.king(x, b.column("yellow", x, z, 1, { 0.42, 1.5, 0.42 }), z)
    b.add("rock", x - 1.6, 1.6, z - 0.2, { 0.8, 3.2, 3.6 })
    b.add("rock", x + 1.6, 1.6, z - 0.2, { 0.8, 3.2, 3.6 })
    b.add("rock", x, 3.45, z, { 4, 0.5, 4.4 })
end

local function keep(b)
    local top = b.tower({ "stone" }, 28, 0, 3.2, 14, 8, 0.8, 0.6)
    for i = 0, 6 do
        local angle = 2 * pi * (i + 0.25) / 7
        b.add("stone", 28 + 3.2 * math.cos(angle), top + 0.3, 3.2 * math.sin(angle), { 0.8, 0.6, 0.8 }, { angle, 0, 0 })
    end
    b.king(28, b.column("wood", 28, 0, 3, { 1, 0.8, 1 }), 0)
end

local function see_saw(b)
    local foot = b.add("rock", 24, 0.6, 0, { 0.9, 1.2, 0.5 })
    local plank = b.add("wood", 24, 1.36, 0, { 1.4, 0.24, 10 })
    daft.joint { kind = "hinge", a = foot, b = plank, at = { 24, 1.36, 0 }, axis = { 1, 0, 0 }, limit = { -0.24, 0.24 }, collide = false }
    b.column("yellow", 24, 4.4, 2, { 0.6, 0.61, 0.6 })
    b.king(24, 1.48, 4.2)
    b.add("rock", 21.4, 3, 4, { 1, 6, 5.6 })
    b.add("rock", 24.4, 6.3, 4, { 7, 0.6, 5.6 })
    b.add("rock", 27, 3, 4, { 1, 6, 5.6 })
    b.thing { parent = plank, box = { 1.3, 0.02, 1.3 }, position = { 0, 0.13, -4.2 }, material = "target" }
end

local function wrecking_ball(b)
    local x, high, rope, start = 25, 9, 7, 1.1 -- metres; radians from the plumb line
    b.add("rock", x + 2.6, high / 2, 0, { 0.8, high, 0.8 })
    b.add("bar", x + 1, high + 0.2, 0, { 4, 0.4, 0.5 })
    local y, z = high - rope * math.cos(start), -rope * math.sin(start)
    local ball = b.thing { sphere = 0.9, position = { x, y, z }, body = "dynamic", mass = 1400, rolling_resistance = 0.3, friction = 1, data = { kind = "iron" },
        material = { color = "#31353d", specular = 0.8, shininess = 100, mirror = 0.15 } }
    b.rope(ball, { x, high, 0 }, rope + 0.06)
    b.column({ "red", "white" }, x, z, 4, { 0.9, (y - 0.9) / 4, 0.9 })
    local top = b.tower({ "blue", "white", "yellow" }, x, 3.6, 1.3, 8, 9, 0.5, 0.44)
    b.add("wood", x, top + 0.1, 3.6, { 3, 0.2, 3 })
    b.king(x, top + 0.2, 3.6)
    b.add("rock", x - 3, 3.4, 3.2, { 1, 6.8, 6.8 })
    b.add("rock", x - 1.2, 7, 4.2, { 4.6, 0.5, 4.6 })
end

local function guest(b)
    b.lady(20, b.column({ "white", "green" }, 20, 0, 5, { 1, 0.8, 1 }), 0)
    b.king(26.5, b.column({ "red", "purple" }, 26.5, 0, 4, { 1.1, 0.8, 1.1 }), 0)
    for _, z in ipairs { -3, 3 } do
        b.king(26.5, b.column({ "purple", "red" }, 26.5, z, 3, { 1.1, 0.8, 1.1 }), z)
    end
end

local function bridge(b)
    local x, high, count, half = 26, 5, 12, 6 -- metres: half of the gap
    local sides = {}
    for side = -1, 1, 2 do
        sides[side] = b.add("rock", x, high / 2, side * (half + 2.2), { 4, high, 4.4 })
        b.column({ "blue", "white" }, x - 1.2, side * (half + 1), 3, { 0.6, 0.5, 0.6 }, high)
        b.column({ "blue", "white" }, x + 1.2, side * (half + 1), 3, { 0.6, 0.5, 0.6 }, high)
    end
    local function sag(i) return high - 0.15 - 1.1 * (1 - (2 * i / count - 1) ^ 2) end
    local before = sides[-1]
    for i = 1, count do
        local z0, z1, y0, y1 = -half + (i - 1) * 2 * half / count, -half + i * 2 * half / count, sag(i - 1), sag(i)
        local long = math.sqrt((z1 - z0) ^ 2 + (y1 - y0) ^ 2)
        local plank = b.add("wood", x, (y0 + y1) / 2, (z0 + z1) / 2, { 1.6, 0.16, long - 0.06 }, { 0, 0, math.atan(y0 - y1, z1 - z0) })
        daft.joint { kind = "hinge", a = before, b = plank, at = { x, y0, z0 }, axis = { 1, 0, 0 }, break_force = 26000 }
        before = plank
    end
    daft.joint { kind = "hinge", a = before, b = sides[1], at = { x, sag(count), half }, axis = { 1, 0, 0 }, break_force = 26000 }
    for _, z in ipairs { -1.5, 0.5, 2.5 } do b.king(x, sag((z + half) * count / half / 2) + 0.09, z) end
end

local function babel(b)
    local top = b.tower({ "red", "yellow", "blue", "white", "green" }, 29, 0, 3.4, 16, 26, 0.7, 0.42)
    for i = -3, 3 do b.add("wood", 29, top + 0.1, i, { 7.4, 0.2, 0.96 }) end
    b.king(29, top + 0.2, 0)
    local upper = b.tower({ "purple", "white" }, 29, 0, 2.4, 10, 4, 0.5, 0.4, top + 0.2)
    for i = -2, 2 do b.add("wood", 29, upper + 0.08, i, { 5, 0.16, 0.96 }) end
    b.king(29, upper + 0.16, 0)
    for _, z in ipairs { -6, 6 } do -- two posts at the gate, fourteen blocks each
        b.column({ "white", "purple" }, 25, z, 14, { 0.8, 0.5, 0.8 })
    end
end

return {
    { name = "Knock, knock", hint = "Aim, hold to pull, let go", shots = { "stone", "stone", "stone" }, par = 1,
        light = "day", view = { 24, 2, 0, 6 }, build = knock },
    { name = "House of cards", hint = "He is proud of it", shots = { "stone", "stone", "stone" }, par = 1,
        light = "day", view = { 22, 3, 0, 9 }, build = cards },
    { name = "Two birds", hint = "How many stones?", shots = { "stone", "stone", "stone" }, par = 1,
        light = "day", view = { 25, 3, 0, 9 }, build = birds },
    { name = "Fall in line", hint = "One thing leads to another", shots = { "stone", "stone", "stone" }, par = 1,
        light = "evening", view = { 21, 1, -3, 14 }, build = fall_in_line },
    { name = "The keep", hint = "Walls keep out what flies low", shots = { "stone", "stone", "iron", "iron" }, par = 2,
        light = "evening", view = { 28, 3, 0, 8 }, build = keep },
    { name = "See-saw", hint = "He looks down on you: help him up", shots = { "iron", "iron", "iron" }, par = 1,
        light = "day", view = { 24, 2, 0, 10 }, build = see_saw },
    { name = "On a thread", hint = "What holds the ball?", shots = { "stone", "stone", "stone" }, par = 1,
        light = "evening", view = { 25, 4, 0, 12 }, build = wrecking_ball },
    { name = "The guest", hint = "Mind the lady in green", shots = { "stone", "stone", "stone", "iron", "iron" }, par = 3,
        light = "day", view = { 24, 3, 0, 9 }, build = guest },
    { name = "A bridge too far", hint = "Bombs go off where they hit", shots = { "bomb", "bomb", "bomb" }, par = 1,
        light = "dusk", view = { 26, 4, 0, 14 }, build = bridge },
    { name = "Babel", hint = "Pride comes before the fall", shots = { "bomb", "iron", "bomb", "iron", "bomb" }, par = 3,
        light = "dusk", view = { 29, 7, 0, 21 }, build = babel },
}
