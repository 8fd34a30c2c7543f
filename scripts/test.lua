-- For the tests of a game: files in its folder tests/, which `daft test-game` runs. See docs/guide/testing-games.md.
--
--     local test = require "test"
--     test("the ball jumps", function()
--       test.press("space")
--       test.seconds(0.2)
--       test.above(ball:velocity(), 0)
--     end)

local test = {}

-- Presses a key, or a button as in "mouse1", for so many seconds; a tick unless given.
function test.press(key, seconds)
  daft.input.set(key, true)
  if seconds then wait(seconds) else test.ticks(1) end
  daft.input.set(key, false)
  test.ticks(1)
end

-- Holds keys until test.release, or the test's end.
function test.hold(...)
  for _, key in ipairs { ... } do daft.input.set(key, true) end
end

function test.release(...)
  for _, key in ipairs { ... } do daft.input.set(key, false) end
end

-- The game goes on for so many ticks of 1/60 s, or seconds.
function test.ticks(count)
  local till = daft.tick() + count
  repeat wait() until daft.tick() >= till
end

test.seconds = wait

-- The game goes on until the function says true; the test fails where that takes longer than so many seconds.
function test.wait_for(f, seconds)
  local till = daft.time() + (seconds or 10)
  while not f() do
    if daft.time() >= till then error(("it did not happen within %g s"):format(seconds or 10), 2) end
    wait()
  end
end

local function say(what, message)
  return message and ("%s: %s"):format(message, what) or what
end

local function show(value)
  return type(value) == "string" and ("%q"):format(value) or tostring(value)
end

function test.equal(got, wanted, message)
  if got ~= wanted then error(say(("%s expected, got %s"):format(show(wanted), show(got)), message), 2) end
end

-- Numbers that differ by at most `tolerance` (0.001).
function test.near(got, wanted, tolerance, message)
  tolerance = tolerance or 0.001
  if type(got) == "number" and math.abs(got - wanted) <= tolerance then return end
  error(say(("%g ± %g expected, got %s"):format(wanted, tolerance, show(got)), message), 2)
end

function test.above(got, limit, message)
  if type(got) == "number" and got > limit then return end
  error(say(("more than %g expected, got %s"):format(limit, show(got)), message), 2)
end

function test.below(got, limit, message)
  if type(got) == "number" and got < limit then return end
  error(say(("less than %g expected, got %s"):format(limit, show(got)), message), 2)
end

-- The function fails, with a message in which the text is.
function test.fails(f, text)
  local good, message = pcall(f)
  if good then error("an error expected", 2) end
  if text and not tostring(message):find(text, 1, true) then
    error(("an error with %q expected, got %q"):format(text, tostring(message)), 2)
  end
end

test.picture = daft.test.picture

return setmetatable(test, { __call = function(_, name, f) daft.test(name, f) end })
