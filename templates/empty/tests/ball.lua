local test = require "test"

-- The nearest thing below a place high above the middle of the floor is the ball.
local function height()
  local hit = daft.raycast({0, 50, 0}, {0, -1, 0})
  assert(hit.entity.name == "ball", "the ball is on the floor's middle")
  return hit.position[2] - 1
end

test("the ball comes to rest on the floor", function()
  test.seconds(6)
  test.near(height(), 0, 0.02)
end)

test("space makes it jump", function()
  test.seconds(6)
  test.press("space")
  test.seconds(0.3)
  test.above(height(), 0.5)
end)

test("it looks as it did", function()
  test.seconds(6)
  test.picture("rest")
end)
