-- Nothing moves: only what is sampled differs from picture to picture.
function daft.load()
  daft.camera.set { position = {0, 3, 0}, pitch = 1.2, teleport = true }
  daft.ambient({ 0.3, 0.3, 0.3 }, 1)
  daft.light.point { position = {1, 4, 0}, radius = 0.5 }
  daft.entity { box = {12, 0.2, 12}, position = {3, -0.1, 0} }
  daft.entity { sphere = 0.5, position = {1.2, 0.6, 0} }
end
