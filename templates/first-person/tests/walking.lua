local test = require "test"

test("walking ahead finds the light in the middle", function()
  test.hold("w")
  test.wait_for(function() return game.found > 0 end, 8)
  assert(game.lights[1].found, "it is the one in the middle")
end)

test("the wall ends the walk", function()
  test.press("s", 4)
  local eye = daft.camera.get().position
  test.near(eye[1], -21.3, 0.05)
end)

test("space jumps, and only from the ground", function()
  test.seconds(0.5)
  local low = daft.camera.get().position[2]
  test.press("space")
  test.seconds(0.3)
  local high = daft.camera.get().position[2]
  test.above(high, low + 0.5)
  test.press("space") -- in the air: nothing more
  test.seconds(1.5)
  test.near(daft.camera.get().position[2], low, 0.01)
end)

test("R starts again", function()
  test.press("w", 5)
  test.press("r")
  test.equal(game.found, 0)
end)

test("it looks as it did", function()
  test.ticks(2)
  test.picture("garden")
end)
