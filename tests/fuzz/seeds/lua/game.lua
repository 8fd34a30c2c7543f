local ball
function daft.load()
  daft.sky.gradient("#6fb7ff", "#f2f6ff")
  daft.light.sun { direction = { -1, -2, -0.5 }, color = { 1, 0.96, 0.9 } }
  daft.entity { box = { 20, 1, 20 }, position = { 0, -0.5, 0 }, body = "static" }
  ball = daft.entity { sphere = 0.5, position = { 0, 4, 0 }, material = { mirror = 0.8 }, body = "dynamic" }
  daft.camera.look { from = { -8, 4, 0 }, at = ball }
end
function daft.update(dt) if daft.input.down("space") then ball:push(0, 0, -6) end end
function daft.draw() daft.text(("tick %d"):format(daft.tick()), 16, 16) daft.rect(1, 2, 3, 4, "#f008") end
function daft.keypressed(key) ball:impulse(0, 1, 0) end
