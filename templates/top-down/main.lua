-- Top down: run over a plaza and take the coins; the balls that roll about are in a hurry too.
-- WASD or the arrow keys run, R starts again.

local SPEED, SIZE, LIVES = 6, 9, 3 -- m/s, half the plaza's width, balls that one survives

game = { coins = 0, best = 0, lives = LIVES, over = false } -- a global, so that the tests see it too

local runner, body, coin, balls, safe, sounds = nil, nil, nil, {}, 0, {}

local COLORS = { "#d8432f", "#2f7fd8", "#3fae5a", "#8c4fc0" }

local function place_coin()
  local x, _, z = runner:position()
  local cx, cz
  repeat -- not where the runner is
    cx, cz = (daft.random() * 2 - 1) * (SIZE - 1), (daft.random() * 2 - 1) * (SIZE - 1)
  until (cx - x) ^ 2 + (cz - z) ^ 2 > 9
  coin:teleport(cx, 0.8, cz)
end

local function add_ball()
  local side = daft.random() < 0.5 and -1 or 1
  local ball = daft.entity { sphere = 0.6, position = {side * (SIZE - 1), 0.7, (daft.random() * 2 - 1) * (SIZE - 2)},
    body = "dynamic", mass = 5, friction = 0, restitution = 1, sleeps = false, name = "ball",
    velocity = {-side * (3 + daft.random()), 0, 2 * daft.random() - 1},
    material = { color = COLORS[#balls % #COLORS + 1], specular = 0.7, shininess = 200, mirror = 0.08 } }
  table.insert(balls, ball)
end

local function start()
  for _, ball in ipairs(balls) do ball:destroy() end
  balls = {}
  runner:position(0, 0.9, 0)
  game.coins, game.lives, game.over, safe = 0, LIVES, false, 2
  place_coin()
  add_ball()
  add_ball()
end

function daft.load()
  daft.sky.gradient("#304050", "#8090a0")
  daft.ambient {0.40, 0.42, 0.48}
  daft.light.sun { direction = {0.5, -1, 0.3}, color = {1, 0.93, 0.8} }
  daft.entity { box = {2 * SIZE, 1, 2 * SIZE}, position = {0, -0.5, 0}, body = "static", friction = 0,
    material = { texture = "cobble", texture_scale = 0.1 } }
  for i = -1, 1, 2 do
    daft.entity { box = {2 * SIZE + 1.6, 1.6, 0.8}, position = {0, 0.3, (SIZE + 0.4) * i}, body = "static",
      material = { texture = "brick", texture_scale = 0.5 }, friction = 0, restitution = 1 }
    daft.entity { box = {0.8, 1.6, 2 * SIZE}, position = {(SIZE + 0.4) * i, 0.3, 0}, body = "static",
      material = { texture = "brick", texture_scale = 0.5 }, friction = 0, restitution = 1 }
  end
  body = daft.entity {}
  daft.entity { sphere = 0.45, position = {0, -0.3, 0}, parent = body, material = "#f0f0f4" }
  daft.entity { sphere = 0.32, position = {0, 0.35, 0}, parent = body, material = "#f4c89a" }
  daft.entity { box = {0.5, 0.08, 0.5}, position = {0, 0.62, 0}, parent = body, material = "#27456e" }
  runner = daft.character { position = {0, 0.9, 0}, radius = 0.4, height = 1.6, entity = body, force = 0 }
  coin = daft.entity { mesh = "meshes/coin.obj", scale = 1.2, material = { color = "#ffcc33", specular = 0.9, emission = 0.2 } }
  sounds.coin = daft.sound { notes = "b5 e6", beat = 0.07, decay = 0.3 }
  sounds.hit = daft.sound { wave = "noise", pitch = 300, slide = 60, decay = 0.4, cut = 1500 }
  game.best = daft.load_saved("best") or 0
  daft.camera.look { from = {0, 16, 9.5}, at = {0, 0, 0.9}, fov = math.rad(72), teleport = true }
  start()
end

-- -1, 0 or 1, by the letters or the arrow keys.
local function axis(minus, plus, minus_letter, plus_letter)
  local sum = daft.input.axis(minus, plus) + daft.input.axis(minus_letter, plus_letter)
  return math.max(-1, math.min(1, sum))
end

local function run()
  local x, z = axis("left", "right", "a", "d"), axis("up", "down", "w", "s")
  local speed = game.over and 0 or SPEED / math.max(1, math.sqrt(x * x + z * z))
  runner:walk(x * speed, z * speed)
end

local function take_coin(x, z)
  coin:rotation(3 * daft.time(), 0, 0)
  local cx, _, cz = coin:position()
  if (cx - x) ^ 2 + (cz - z) ^ 2 > 1 then return end
  game.coins = game.coins + 1
  sounds.coin:play()
  place_coin()
  if game.coins % 3 == 0 then add_ball() end
end

local function lose_life()
  game.lives, safe = game.lives - 1, 1.5
  sounds.hit:play()
  game.over = game.lives == 0
  if game.over and game.coins > game.best then
    game.best = game.coins
    daft.save("best", game.best)
  end
end

-- Each ball keeps its speed, whatever it has run into.
local function roll_balls(x, z)
  for _, ball in ipairs(balls) do
    local vx, vy, vz = ball:velocity()
    local speed = math.sqrt(vx * vx + vz * vz)
    if speed < 0.01 then vx, speed = 1, 1 end
    ball:velocity(vx / speed * 4, vy, vz / speed * 4)
    local bx, _, bz = ball:position()
    if safe <= 0 and (bx - x) ^ 2 + (bz - z) ^ 2 < 1.1 then lose_life() end
  end
end

function daft.update(dt)
  run()
  local x, _, z = runner:position()
  safe = safe - dt
  body:visible(safe <= 0 or math.floor(safe * 10) % 2 == 0) -- blinks while nothing can happen to it
  if game.over then return end
  take_coin(x, z)
  roll_balls(x, z)
end

function daft.keypressed(key)
  if key == "r" then start() end
end

function daft.draw()
  daft.text(("%d coins   %d lives   best %d"):format(game.coins, game.lives, game.best), 24, 20)
  if game.over then
    daft.text("Game over", daft.width() / 2, 240, { size = 80, align = "center", color = "#ffd0a0" })
    daft.text("R starts again", daft.width() / 2, 340, { size = 28, align = "center" })
  end
end
