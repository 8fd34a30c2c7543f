-- daft.load: weak keys that hang on each other
function daft.load()
    local keys = {}
    for i = 1, 60000 do keys[i] = {} end
    local chain = {}
    for i = 60000, 2, -1 do chain[i] = setmetatable({ [keys[i]] = keys[i - 1] }, { __mode = "k" }) end
    local first = keys[60000]
    keys = nil
    while true do collectgarbage() end
end
