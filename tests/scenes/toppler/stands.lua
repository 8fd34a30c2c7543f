-- Appended to games/toppler/main.lua by test_games: nobody throws, and for ten seconds nothing moves in any level.

local update, number = daft.update, 0

function daft.update(dt)
    update(dt)
    if daft.tick() % 600 ~= 1 then return end
    if number > 0 then
        assert(game.state == "aim" and game.points == 0 and game.kings == #blocks.kings and not game.lady_fell,
            ("level %d does not stand: %d points"):format(number, game.points))
        print(("level %d stands: %d bodies"):format(number, blocks.count()))
    end
    number = number + 1
    if not levels[number] then return daft.quit() end
    play(number)
end
