local test = require "test"

test("the keys run, and the wall stops", function()
  test.press("d", 3)
  local hit = daft.raycast({8.55, 10, 0}, {0, -1, 0})
  test.above(hit.position[2], 0.5, "what stands at the wall")
end)

test("a ball costs a life, and not two at once", function()
  test.wait_for(function() return game.lives < 3 end, 60)
  test.seconds(1)
  test.equal(game.lives, 2)
end)

test("R starts again", function()
  test.press("w", 1)
  game.coins = 5
  test.press("r")
  test.equal(game.coins, 0)
end)

test("it looks as it did", function()
  test.ticks(2)
  test.picture("plaza")
end)
