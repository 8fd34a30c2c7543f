-- Sample: the game of the design page, as it stands there.
local ball, score = nil, 0

function daft.load()
  daft.sky.gradient("#6fb7ff", "#f2f6ff")
  daft.light.sun { direction = {-1, -2, -0.5}, color = {1, 0.96, 0.9} }
  daft.entity { box = {20, 1, 20}, position = {0, -0.5, 0}, material = "checker", body = "static" }
  ball = daft.entity { sphere = 0.5, position = {0, 4, 0}, material = { mirror = 0.8 }, body = "dynamic" }
  daft.camera.look { from = {-8, 4, 0}, at = ball }
end

function daft.update(dt)                                   -- fixed step, 1/60 s
  if daft.input.down("left") then ball:push(0, 0, -6) end
end

function daft.draw()                                       -- every frame, over the picture
  daft.text(("score %d"):format(score), 16, 16)
end
