local test = require "test"

test("rolling ahead takes the first two gems", function()
  test.hold("up")
  test.wait_for(function() return game.taken == 2 end, 6)
  assert(game.gems[1].taken and game.gems[2].taken)
end)

test("who falls begins again", function()
  test.press("left", 4)
  test.below(game.time, 4, "the clock")
  test.equal(game.taken, 0)
end)

test("no gem, no goal", function()
  test.seconds(1)
  test.equal(game.won, false)
end)

test("it looks as it did", function()
  test.ticks(2)
  test.picture("start")
end)
