-- Broken: an error in the tenth update.
local nothing
function daft.update()
    if daft.tick() == 9 then
        return nothing.field
    end
end
