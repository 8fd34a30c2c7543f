local function inner()
    wait(0.05)
    local nothing
    return nothing.field
end

function daft.load()
    daft.start(function()
        inner()
    end)
end
