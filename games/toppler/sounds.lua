-- What is heard: made of numbers, so that the game has no sound files.

local sounds = {}

local HITS_A_TICK = 3 -- louder ones first: more than that is only noise

local effects, creak, bass

local SONGS = {
    title = { beat = 0.24, high = "d5 - f#5 a5 - f#5 b5 - a5 f#5 - e5 d5 - e5 f#5 - d5 e5 - c#5 a4 - - "
        .. "d5 - f#5 a5 - f#5 b5 - d6 a5 - f#5 g5 - e5 c#5 - e5 d5 - - d5 - -",
        low = "d3 a3 f#3 d3 a3 f#3 g2 d3 b3 d3 a3 f#3 b2 f#3 d3 b2 f#3 d3 e3 b3 g3 a2 e3 c#3 "
        .. "d3 a3 f#3 d3 a3 f#3 g2 d3 b3 f#3 a3 d3 e3 b3 g3 a2 e3 g3 d3 a3 f#3 d3 a2 -" },
    play = { beat = 0.2, high = "a4 - c5 d5 - e5 d5 c5 a4 - g4 a4 - - - - a4 - c5 d5 - e5 g5 e5 d5 - c5 d5 - - - - "
        .. "e5 - d5 e5 - g5 a5 g5 e5 - d5 c5 - - - - a4 - c5 d5 - c5 a4 g4 a4 - - a4 - - - -",
        low = "a2 - e3 - a2 - e3 - a2 - e3 - g2 - d3 - a2 - e3 - a2 - e3 - d2 - a2 - d2 - a2 - "
        .. "c3 - g3 - c3 - g3 - f2 - c3 - f2 - c3 - a2 - e3 - d2 - g2 - a2 - e3 - a2 - - -" },
}

function sounds.load()
    effects = {
        wood = daft.sound { wave = "triangle", pitch = 240, slide = 150, attack = 0.001, decay = 0.1, volume = 0.8 },
        stone = daft.sound { wave = "noise", pitch = 300, slide = 90, attack = 0.001, decay = 0.16, cut = 900, volume = 1 },
        card = daft.sound { wave = "noise", pitch = 5000, slide = 3000, attack = 0.001, decay = 0.05, volume = 0.35 },
        iron = daft.sound { wave = "square", pitch = 620, slide = 590, attack = 0.001, decay = 0.2, cut = 2600, volume = 0.35 },
        thud = daft.sound { wave = "noise", pitch = 80, slide = 35, attack = 0.001, decay = 0.25, cut = 380, volume = 1 },
        throw = daft.sound { wave = "saw", pitch = 90, slide = 340, attack = 0.004, decay = 0.24, cut = 1500, volume = 0.6 },
        whoosh = daft.sound { wave = "noise", pitch = 900, slide = 300, attack = 0.1, decay = 0.6, cut = 1200, volume = 0.5 },
        boom = daft.sound { wave = "noise", pitch = 200, slide = 25, attack = 0.002, hold = 0.08, decay = 0.9, cut = 700, volume = 1 },
        yelp = daft.sound { pitch = 720, slide = 260, attack = 0.01, decay = 0.5, vibrato = 1.2, vibrato_rate = 9, volume = 0.5 },
        scream = daft.sound { pitch = 980, slide = 640, attack = 0.01, decay = 0.7, vibrato = 1.5, vibrato_rate = 11, volume = 0.5 },
        tick = daft.sound { wave = "triangle", pitch = 900, attack = 0.001, decay = 0.05, volume = 0.4 },
        choose = daft.sound { wave = "triangle", notes = "a5 d6", beat = 0.06, decay = 0.15, volume = 0.4 },
        win = daft.sound { wave = "square", notes = "d5 - d5 d5 f#5 - a5 - f#5 a5 d6 - - -", beat = 0.11, decay = 0.4, cut = 3000, volume = 0.4 },
        lose = daft.sound { wave = "triangle", notes = "f4 e4 eb4 d4 - - -", beat = 0.22, decay = 0.5, vibrato = 0.3, volume = 0.6 },
        star = daft.sound { notes = "e6 b6", beat = 0.07, decay = 0.3, volume = 0.4 },
    }
    creak = daft.sound { wave = "saw", pitch = 46, hold = 1, decay = 0.05, attack = 0.05, vibrato = 0.8, vibrato_rate = 13, cut = 500, volume = 0.5 }
    for _, song in pairs(SONGS) do
        song.tune = daft.sound { wave = "triangle", notes = song.high, beat = song.beat, attack = 0.004, decay = 0.45, volume = 0.4 }
        song.bass = daft.sound { wave = "square", notes = song.low, beat = song.beat, attack = 0.006, decay = 0.4, cut = 620, volume = 0.5 }
    end
end

function sounds.play(name, options)
    options = options or {}
    options.group = "effects"
    effects[name]:play(options)
end

local playing
function sounds.music(name)
    if playing == name then return end
    playing = name
    if bass then bass:stop(1) end
    daft.music(SONGS[name].tune, { fade = 1 })
    bass = SONGS[name].bass:play { loop = true, group = "music", fade = 1 }
end

local creaking
-- How far the catapult is pulled; nil when it is not.
function sounds.pull(amount)
    if amount and not creaking then creaking = creak:play { loop = true, group = "effects", volume = 0 } end
    if creaking and not amount then
        creaking:stop(0.05)
        creaking = nil
    elseif creaking then
        creaking:volume(amount < 1 and 0.5 or 0)
        creaking:pitch(0.8 + amount)
    end
end

local SOUND_OF = { wood = "wood", stone = "stone", rock = "stone", card = "card", iron = "iron", bar = "iron", ground = "thud", bomb = "iron",
    king = "wood", lady = "wood" }

local hits = {}
-- Something met something: remembered until sounds.update, which plays the loudest.
function sounds.hit(event)
    hits[#hits + 1] = event
end

function sounds.update()
    if #hits > HITS_A_TICK then table.sort(hits, function(a, b) return a.speed > b.speed end) end
    for i = 1, math.min(#hits, HITS_A_TICK) do
        local event = hits[i]
        local kind = (event.a.data and event.a.data.kind ~= "ground" and event.a or event.b).data
        local name = kind and SOUND_OF[kind.kind] or "wood"
        sounds.play(name, { at = event.point, near = 14, far = 120, volume = math.min(1.6, event.speed / 8),
            pitch = 0.85 + 0.3 * daft.random() })
    end
    hits = {}
end

return sounds
