-- Empty: a floor, a ball and a camera to begin with.
-- Space makes the ball jump.

local ball

function daft.load()
  daft.sky.gradient("#5b9bd8", "#dfeaf4")
  daft.ambient({0.35, 0.38, 0.45}, 1)
  daft.light.sun { direction = {0.6, -1, -0.5}, color = {1, 0.95, 0.85} }
  daft.entity { box = {12, 1, 12}, position = {0, -0.5, 0}, body = "static",
    material = { color = "#d9c9a8", specular = 0.1 } }
  ball = daft.entity { sphere = 0.5, position = {0, 3, 0}, body = "dynamic", mass = 1, restitution = 0.5, name = "ball",
    material = { color = "#d8422f", specular = 0.6, shininess = 120, mirror = 0.1 } }
  daft.camera.look { from = {-6, 3, 3}, at = {0, 0.8, 0}, fov = math.rad(60) }
end

function daft.keypressed(key)
  if key == "space" then ball:impulse(0, 5, 0) end
end

function daft.draw()
  local _, y = ball:position()
  daft.text(("height %.1f m"):format(math.max(0, y - 0.5)), 24, 20)
end
