-- daft.load: unpack of nine hundred thousand values
function daft.load() local t = {} for i = 1, 900000 do t[i] = i end while true do select(-1, table.unpack(t)) end end
