-- the simulation of one tick: bodies all in one place
function daft.load()
    for i = 1, 9000 do daft.entity { box = { 1, 1, 1 }, position = { i % 7 * 0.01, i % 11 * 0.01, i % 13 * 0.01 }, body = "dynamic" } end
end
