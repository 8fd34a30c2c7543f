-- First person: a garden at dusk, in which seven lights are to be found.
-- WASD or the arrow keys walk, the mouse looks around, space jumps, R starts again.

local SPEED, JUMP, EYE = 4.5, 4.5, 0.7 -- m/s, m/s, metres above the walker's middle
local LOOK = 0.0035                    -- radians for each HUD unit of the mouse

game = { found = 0, time = 0, lights = {} } -- a global, so that the tests see it too

local walker, yaw, pitch, ding

local function build_garden()
  daft.entity { box = {44, 1, 44}, position = {0, -0.5, 0}, material = { texture = "grass", texture_scale = 0.3 },
    body = "static" }
  for i = -1, 1, 2 do -- the wall around it
    daft.entity { box = {44, 2.4, 0.8}, position = {0, 1.2, 22 * i}, material = "#8a7f75", body = "static" }
    daft.entity { box = {0.8, 2.4, 44}, position = {22 * i, 1.2, 0}, material = "#8a7f75", body = "static" }
  end
  for i = 0, 11 do -- a ring of columns, on which slabs lie
    local angle = i / 12 * 2 * math.pi
    local x, z = 9 * math.cos(angle), 9 * math.sin(angle)
    daft.entity { mesh = "meshes/column.obj", position = {x, 0, z}, body = "static", collider = "mesh" }
  end
  daft.entity { box = {5, 0.3, 5}, position = {0, 0.15, 0}, material = "#b9b2a6", body = "static" }
  daft.entity { box = {3.4, 0.3, 3.4}, position = {0, 0.45, 0}, material = "#c9c2b4", body = "static" }
  for i = 1, 26 do
    local angle, far = daft.random() * 2 * math.pi, 12 + 8 * daft.random()
    local pine = daft.random() < 0.5
    daft.entity { mesh = pine and "meshes/pine.obj" or "meshes/rock.obj", body = "static",
      position = {far * math.cos(angle), 0, far * math.sin(angle)}, rotation = {daft.random() * 6, 0, 0},
      scale = pine and 0.8 + 0.5 * daft.random() or 0.4 + 0.4 * daft.random() }
  end
end

local function add_light(x, y, z)
  local lamp = daft.entity { sphere = 0.22, position = {x, y, z}, casts_shadow = false,
    material = { color = "#ffe0a0", emission = {1, 0.75, 0.35} } }
  local glow = daft.light.point { position = {x, y + 0.3, z}, color = {1.6, 1.1, 0.5}, range = 6 }
  table.insert(game.lights, { lamp = lamp, glow = glow, x = x, y = y, z = z })
end

local function start()
  walker:position(-16, 0.9, 0)
  yaw, pitch = 0, 0
  game.found, game.time = 0, 0
  for _, light in ipairs(game.lights) do
    light.found = false
    light.lamp:visible(true)
    light.glow:color {1.6, 1.1, 0.5}
  end
end

function daft.load()
  daft.sky.gradient("#27365f", "#e8a070")
  daft.ambient {0.20, 0.22, 0.32}
  daft.light.sun { direction = {0.8, -0.35, 0.5}, color = {1, 0.62, 0.38} }
  build_garden()
  add_light(0, 1.1, 0)
  for i = 1, 6 do
    local angle = i / 6 * 2 * math.pi + 0.4
    local far = i % 2 == 0 and 7 or 15
    add_light(far * math.cos(angle), 0.8, far * math.sin(angle))
  end
  ding = daft.sound { notes = "e5 b5", beat = 0.08, decay = 0.6 }
  walker = daft.character { position = {-16, 0.9, 0} }
  daft.input.mouse.grab(true)
  start()
end

-- -1, 0 or 1, by the letters or the arrow keys.
local function axis(minus, plus, minus_letter, plus_letter)
  local sum = daft.input.axis(minus, plus) + daft.input.axis(minus_letter, plus_letter)
  return math.max(-1, math.min(1, sum))
end

local function walk()
  local ahead, aside = axis("down", "up", "s", "w"), axis("left", "right", "a", "d")
  local speed = SPEED / math.max(1, math.sqrt(ahead * ahead + aside * aside))
  local cos, sin = math.cos(yaw), math.sin(yaw)
  walker:walk((cos * ahead - sin * aside) * speed, (sin * ahead + cos * aside) * speed)
end

local function look_around()
  local right, down = daft.input.mouse.motion()
  yaw = yaw + right * LOOK
  pitch = math.max(-1.4, math.min(1.4, pitch + down * LOOK))
  local x, y, z = walker:position()
  daft.camera.set { position = {x, y + EYE, z}, yaw = yaw, pitch = pitch, fov = math.rad(80) }
end

local function find()
  local x, y, z = walker:position()
  for _, light in ipairs(game.lights) do
    local dx, dy, dz = light.x - x, light.y - y, light.z - z
    if not light.found and dx * dx + dy * dy + dz * dz < 1.5 then
      light.found = true
      light.lamp:visible(false)
      light.glow:color {0, 0, 0}
      game.found = game.found + 1
      ding:play()
    end
  end
end

function daft.update(dt)
  if game.found < #game.lights then game.time = game.time + dt end
  for i, light in ipairs(game.lights) do
    light.lamp:position(light.x, light.y + 0.12 * math.sin(2 * daft.time() + i), light.z)
  end
  walk()
  look_around()
  find()
end

function daft.keypressed(key)
  if key == "space" then walker:jump(JUMP) end
  if key == "r" then start() end
end

function daft.draw()
  daft.text(("%d of %d lights   %.0f s"):format(game.found, #game.lights, game.time), 24, 20)
  local middle = daft.width() / 2
  daft.rect(middle - 2, 358, 4, 4, "#ffffffa0")
  if game.found == #game.lights then
    daft.text("You found them all!", middle, 250, { size = 64, align = "center", color = "#ffe9b0" })
    daft.text("R starts again", middle, 330, { size = 28, align = "center" })
  end
end
