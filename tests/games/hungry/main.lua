-- Hungry: holds a megabyte more with each update, and sees whether it can catch what follows.
local held, ended = {}, 0
function daft.update()
    local good, why = pcall(string.rep, tostring(#held) .. "-", 500000)
    if good then
        held[#held + 1] = why
        return
    end
    ended = ended + 1
    if ended == 1 then print("caught\t" .. why) end
    while true do held[#held + 1] = { #held } end
end
