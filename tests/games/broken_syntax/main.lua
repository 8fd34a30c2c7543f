-- Broken: a syntax error in line 3.
function daft.load()
    local x = = 3
end
