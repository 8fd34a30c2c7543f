-- Tasks: each step happens in the tick that the manual names.

local log = {}
local function note(what) log[#log + 1] = ("%d %s"):format(daft.tick(), what) end
local open, ticks, cancelled, child = false, 0, nil, nil

local function refused(message, f, ...)
    local good, error = pcall(f, ...)
    assert(not good and tostring(error):find(message, 1, true), tostring(error))
end

function daft.load()
    daft.start(function(a, b)
        note("start " .. a .. b)
        wait(0.1)
        note "waited"
        wait()
        note "next"
        assert(pcall(function() wait(1 / 60) end))
        note "in pcall"
        coroutine.yield()
        note "yielded"
        wait_until(function() return open end)
        note "open"
        child = daft.start(function() wait(0) note "child" end)
        assert(daft.running(child))
    end, "a", "b")
    note "load"
    daft.after(0.25, function() note "after" open = true wait(0.05) note "later" end)
    local count = 0
    daft.every(0.1, function() count = count + 1 note("every " .. count) wait(0.02) return count < 3 end)
    cancelled = daft.after(0.05, function() error "never" end)
    daft.cancel(cancelled)
    assert(not daft.running(cancelled))
    local own
    own = daft.start(function() wait() daft.cancel(own) wait() error "never" end)
    daft.start(function() -- a coroutine of a task's own is not the task
        local inner = coroutine.wrap(function()
            refused("only within a function that daft.start", wait, 1)
            coroutine.yield(7)
            return 8
        end)
        assert(inner() == 7 and inner() == 8)
    end)
    refused("only within a function that daft.start", wait, 1)
    refused("only within a function that daft.start", wait_until, print)
    refused("daft.start: function: function expected, got the number 3", daft.start, 3)
    refused("seconds: number from 0 to a billion expected", daft.after, -1, print)
    refused("seconds", daft.every, 0 / 0, print)
    refused("task: what daft.start, after or every gave expected", daft.cancel, {})
    for _ = 1, 500 do daft.start(function() wait(0.1) end) end -- many at once
end

function daft.update() ticks = ticks + 1 end

function daft.draw()
    refused("not within daft.draw", daft.start, function() end)
end

local EXPECTED = [[
0 start ab
0 load
6 waited
6 every 1
7 next
8 in pcall
9 yielded
12 every 2
15 after
16 open
17 child
18 later
18 every 3]]

daft.keypressed = nil
daft.start(function()
    wait(0.5)
    local got = table.concat(log, "\n")
    if got ~= EXPECTED then error("got\n" .. got) end
    assert(not daft.running(child) and ticks == 31)
    daft.quit()
end)
