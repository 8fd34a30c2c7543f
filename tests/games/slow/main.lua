-- Slow: time that goes slowly, stands still and goes fast, and what follows it; tables that are used again; noise; streams.

local near = function(a, b, tolerance) return math.abs(a - b) <= (tolerance or 1e-9) end
local function expect_error(pattern, f, ...)
    local good, message = pcall(f, ...)
    assert(not good and message:find(pattern, 1, true), pattern .. ": " .. tostring(message))
end

local stone, floor, waits, everies, updates, begun = nil, nil, {}, 0, 0, 0
local list, inner = {}, nil

local function chance()
    local a, b = daft.random_stream(7), daft.random_stream(7)
    for _ = 1, 10 do
        local x = a:random(100)
        daft.random()
        assert(x == b:random(100) and x >= 1 and x <= 100)
    end
    local before = a:random()
    a:seed(7)
    a:random(100)
    assert(a ~= b and before >= 0 and before < 1 and a:random(5, 5) == 5 and tostring(a):find("stream"))
    expect_error("seed: whole number expected, got nil", daft.random_stream, nil)

    assert(daft.noise(0.3, 0.7) == daft.noise(0.3, 0.7) and daft.noise(0.3, 0.7) ~= daft.noise(0.7, 0.3))
    for dimensions = 1, 4 do
        local low, high, sum = 1, -1, 0
        for i = 1, 4000 do
            local x = {}
            for k = 1, dimensions do x[k] = i * 0.37 * k + k * 0.1 end
            local v = daft.noise(table.unpack(x))
            x[1] = x[1] + 1e-4
            assert(math.abs(daft.noise(table.unpack(x)) - v) < 2e-3, "it has no jumps")
            low, high, sum = math.min(low, v), math.max(high, v), sum + v
        end
        assert(low >= -1 and high <= 1 and low < -0.6 and high > 0.6 and near(sum / 4000, 0, 0.05), dimensions)
    end
    expect_error("1 to 4 numbers expected, got 5", daft.noise, 1, 2, 3, 4, 5)
    expect_error("number within 1e12", daft.noise, 1e13)
end

-- pairs goes through numbers upwards, then strings by their bytes, whatever was done to the table before.
local function order_of_pairs()
    local t = {}
    for i = 50, 1, -1 do t[i] = i end
    for i = 1, 40 do t["k" .. (i * 7) % 41] = i end
    t[true], t[1.5] = 1, 2
    local function keys()
        local out = {}
        for k, v in pairs(t) do
            assert(t[k] == v)
            out[#out + 1] = tostring(k)
        end
        return table.concat(out, " ")
    end
    local function expected()
        local numbers, strings = {}, {}
        for k in next, t do
            if type(k) == "number" then numbers[#numbers + 1] = k elseif type(k) == "string" then strings[#strings + 1] = k end
        end
        table.sort(numbers) table.sort(strings)
        local out = {}
        for _, k in ipairs(numbers) do out[#out + 1] = tostring(k) end
        for _, k in ipairs(strings) do out[#out + 1] = k end
        if t[true] then out[#out + 1] = "true" end
        return table.concat(out, " ")
    end
    for round = 1, 30 do
        assert(keys() == expected() and keys() == expected(), round)
        t["k" .. round], t["n" .. round], t[round], t[100 + round] = nil, round, round % 2 == 0 and 1 or nil, round
        if round == 20 then for i = 1, 50 do t[i] = i end end
    end
    -- What is there may be changed and taken away while it goes on.
    local seen = 0
    for k in pairs(t) do
        t[k] = nil
        seen = seen + 1
    end
    assert(seen > 50 and next(t) == nil)
    local list, sum = { 1, 2, 3, 4 }, 0
    for i in pairs(list) do
        list[i] = nil
        if i == 2 then list[3] = nil end
        sum = sum + i
    end
    assert(sum == 7)
end

function daft.load()
    chance() order_of_pairs()
    floor = daft.entity { box = { 20, 1, 20 }, position = { 0, -0.5, 0 }, body = "static", name = "floor" }
    stone = daft.entity { sphere = 0.5, position = { 0, 100, 0 }, body = "dynamic", mass = 1 }
    assert(daft.time_scale() == 1)
    daft.time_scale(0.5)
    daft.start(function()
        wait(0.5)
        waits.half = daft.tick()
    end)
    daft.start(function()
        for _ = 1, 10 do wait() end
        waits.ten = daft.tick()
    end)
    daft.every(0.1, function() everies = everies + 1 end)
    daft.after(10, function() waits.never = true end)
    expect_error("scale: number from 0 to 4 expected", daft.time_scale, -1)
    expect_error("finite number", daft.time_scale, 0 / 0)
end

local height, speed
function daft.update(dt)
    updates = updates + 1
    local tick = daft.tick()
    assert(updates == tick + 1)
    for _, e in ipairs(daft.events()) do if e.kind == "begin" then begun = begun + 1 end end
    if tick == 11 then assert(waits.ten == 10, "wait() is an update, however fast time goes") end
    if tick < 60 then assert(near(dt, 1 / 120) and near(daft.time(), tick / 120), "half as fast") end
    if tick == 60 then
        local _, y = stone:position()
        assert(near(y, 100 - 9.81 / 2 * 0.25, 0.05), "half a second of fall in a second")
        daft.time_scale(0)
        assert(daft.time_scale() == 0 and near(dt, 1 / 120), "from the next tick on")
    elseif tick == 61 then
        assert(dt == 0)
        assert(waits.half == 60 and everies == 5, everies)
        _, height = stone:position()
        _, speed = stone:velocity()
    elseif tick > 61 and tick < 100 then
        assert(dt == 0 and daft.time() == 61 / 120 and select(2, stone:position()) == height, "time stands still")
        stone:push(0, 1000, 0)
    elseif tick == 100 then
        daft.time_scale(2)
        everies = 0
    elseif tick == 101 then
        assert(near(dt, 1 / 30))
    elseif tick == 102 then
        local _, vy = stone:velocity()
        assert(near(vy, speed - 9.81 / 30, 0.05), "what pushed while time stood still has not added up")
    elseif tick == 130 then
        assert(near(daft.time(), 61 / 120 + 29 / 30, 1e-9) and everies >= 9 and everies <= 10, everies)
        stone:teleport(0, 0.5, 0)
        stone:velocity(0, -3, 0)
        daft.time_scale(1)
        begun = 0
    elseif tick == 133 then
        assert(begun == 1, begun)
        local contacts = stone:contacts(list)
        assert(contacts == list and #list == 1 and list[1].other == floor)
        inner = list[1].point
        list[2], list[3] = {}, 5
        daft.time_scale(0)
    elseif tick == 140 then
        assert(begun == 1, "an event is told once, also where time stands still")
        assert(stone:contacts(list)[1].point == inner and #list == 1, "its tables are used again")
        local hit = { position = {} }
        local position = hit.position
        assert(daft.raycast({ 5, 5, 0 }, { 0, -1, 0 }, 100, nil, hit) == hit and hit.entity == floor)
        assert(hit.position == position and near(position[2], 0, 1e-5))
        assert(daft.query.ray({ 6, 5, 0 }, { 0, -1, 0 }, 100, nil, hit) == hit and near(position[1], 6))
        assert(daft.query.all({ 6, 5, 0 }, { 0, -1, 0 }, 100, nil, list) == list and list[1].entity == floor and #list == 1)
        assert(daft.query.overlap({ sphere = 1 }, { 6, 0, 0 }, nil, list)[1] == floor)
        expect_error("list: table to fill expected, got the number 3", stone.contacts, stone, 3)
        daft.time_scale(1)
    end
    assert(not waits.never)
end

function daft.draw() expect_error("not within daft.draw", daft.time_scale, 0.5) end
