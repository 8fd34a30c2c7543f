-- Marble: a glass ball on tracks in the sky; roll it over the gems and into the ring.
-- WASD or the arrow keys roll, space jumps, R starts again.

local camera = require "camera"

local ROLL, JUMP, DRAG = 16, 5.5, 1.6 -- newtons, m/s, newtons for each m/s; the marble has 1 kg

game = { taken = 0, won = false, time = 0, gems = {} } -- a global, so that the tests see it too

local marble, ring, eye, grounded, sounds

-- x, z, length, width, height of the top
local TRACKS = {
  {0, 0, 8, 4, 0}, {8, 0, 9, 2, 0}, {14.5, 4, 4, 10, 0}, {14.5, 12.5, 4, 5, 0.8}, {7, 13, 11, 1.6, 0.8},
  {-1, 13, 5, 5, 0.4},
}
local GEMS = { {5, 0}, {10, 0.6}, {14.5, 3}, {14.5, 12.5}, {9, 13}, {5, 13} }
local GOAL = {-1, 1.4, 13}

local function build()
  for i, t in ipairs(TRACKS) do
    daft.entity { box = {t[3], 0.5, t[4]}, position = {t[1], t[5] - 0.25, t[2]}, body = "static", friction = 0.9,
      material = { color = i % 2 == 0 and "#d6c6a4" or "#8fb0c8", specular = 0.2 } }
  end
  -- the way up between the tracks of different heights
  daft.entity { box = {4, 0.3, 2}, position = {14.5, 0.27, 9.6}, rotation = {0, 0, 0}, body = "static",
    material = "#e0b060", friction = 0.9 }
  for i, place in ipairs(GEMS) do
    local height = place[2] > 11 and 1.3 or 0.5
    game.gems[i] = { x = place[1], y = height, z = place[2], entity = daft.entity { mesh = "meshes/gem.obj", scale = 0.45,
      position = {place[1], height, place[2]}, material = { color = "#30c0d8", specular = 0.8, emission = 0.15 } } }
  end
  ring = daft.entity { mesh = "meshes/ring.obj", position = GOAL, rotation = {math.pi / 2, 0, 0},
    material = { color = "#f0b428", specular = 0.9, mirror = 0.2 } }
end

local function start()
  marble:teleport(-2, 0.6, 0)
  marble:velocity(0, 0, 0)
  marble:angular_velocity(0, 0, 0)
  game.taken, game.won, game.time = 0, false, 0
  for _, gem in ipairs(game.gems) do
    gem.taken = false
    gem.entity:visible(true)
  end
end

function daft.load()
  daft.sky.gradient("#3f78c0", "#e6f0f6")
  daft.ambient {0.34, 0.38, 0.46}
  daft.light.sun { direction = {0.5, -1, 0.35}, color = {1, 0.94, 0.82} }
  build()
  marble = daft.entity { sphere = 0.4, position = {-2, 0.6, 0}, body = "dynamic", mass = 1, friction = 0.9,
    restitution = 0.3, material = { color = "#20262e", specular = 0.9, shininess = 300, mirror = 0.7 } }
  eye = camera.follow { target = marble, distance = 6, height = 3 }
  sounds = { gem = daft.sound { notes = "g5 d6", beat = 0.07, decay = 0.4 },
    won = daft.sound { notes = "c5 e5 g5 c6", beat = 0.12, decay = 0.7 } }
  start()
end

-- -1, 0 or 1, by the letters or the arrow keys.
local function axis(minus, plus, minus_letter, plus_letter)
  local sum = daft.input.axis(minus, plus) + daft.input.axis(minus_letter, plus_letter)
  return math.max(-1, math.min(1, sum))
end

-- Pushes where the keys say, as seen from the camera.
local function roll()
  local yaw = daft.camera.get().yaw
  local ahead, aside = axis("down", "up", "s", "w"), axis("left", "right", "a", "d")
  local cos, sin = math.cos(yaw), math.sin(yaw)
  local vx, _, vz = marble:velocity()
  grounded = false
  for _, contact in ipairs(marble:contacts()) do grounded = grounded or contact.normal[2] > 0.5 end
  local grip = grounded and 1 or 0.3
  marble:push(((cos * ahead - sin * aside) * ROLL - vx * DRAG) * grip, 0,
    ((sin * ahead + cos * aside) * ROLL - vz * DRAG) * grip)
end

local function near(x, y, z, px, py, pz, far)
  return (x - px) ^ 2 + (y - py) ^ 2 + (z - pz) ^ 2 < far * far
end

local function collect()
  local x, y, z = marble:position()
  for _, gem in ipairs(game.gems) do
    gem.entity:rotation(daft.time() * 2, 0, 0)
    if not gem.taken and near(x, y, z, gem.x, gem.y, gem.z, 0.9) then
      gem.taken = true
      gem.entity:visible(false)
      game.taken = game.taken + 1
      sounds.gem:play()
    end
  end
  if not game.won and game.taken == #game.gems and near(x, y, z, GOAL[1], GOAL[2], GOAL[3], 1.2) then
    game.won = true
    sounds.won:play()
  end
end

function daft.update(dt)
  if not game.won then game.time = game.time + dt end
  roll()
  collect()
  local _, y = marble:position()
  if y < -6 then start() end
  eye:update(dt)
end

function daft.keypressed(key)
  if key == "space" and grounded then marble:impulse(0, JUMP, 0) end
  if key == "r" then start() end
end

function daft.draw()
  daft.text(("%d of %d gems   %.1f s"):format(game.taken, #game.gems, game.time), 24, 20)
  if game.won then
    daft.text("You made it!", daft.width() / 2, 220, { size = 72, align = "center", color = "#fff0c0" })
    daft.text("R starts again", daft.width() / 2, 310, { size = 28, align = "center" })
  end
end
