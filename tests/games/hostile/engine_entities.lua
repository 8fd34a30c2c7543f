-- daft.load: an entity is made and destroyed
function daft.load() while true do daft.entity { box = { 1, 1, 1 } }:destroy() end end
