-- daft.load: a mesh of one point, five million times
function daft.load()
    local points, point = {}, { 0, 0, 0 }
    for i = 1, 5000000 do points[i] = point end
    while true do pcall(daft.mesh, { positions = points, triangles = {} }) end
end
