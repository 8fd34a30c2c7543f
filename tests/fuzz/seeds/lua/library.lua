local camera, tween = require "camera", require "tween"
for k, v in pairs(camera) do print(k, v) end
table.sort({ 3, 1, 2 }, function(a, b) return true end)
print(math.random(10), math.pow(2, 0.5), load("return 1")())
