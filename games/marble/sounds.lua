-- What is heard: made of numbers, so that the game has no sound files.

local sounds = {}

local clink, thud, ring, kick, gem, flag, fall, leap, win
local rolling          -- the voice of the rolling marble
local before           -- the marble's velocity a tick ago

local CHORDS = { -- one bar each: what is plucked, and the bass under it
    { "d4 a4 f#5 a4 d5 a4 f#5 a4", "d2 - - d2 - - a2 -" },
    { "b3 f#4 d5 f#4 b4 f#4 d5 f#4", "b1 - - b1 - - f#2 -" },
    { "g3 d4 b4 d4 g4 d4 b4 d4", "g1 - - g1 - - d2 -" },
    { "a3 e4 c#5 e4 a4 e4 c#5 e4", "a1 - - a1 - - e2 -" },
}

local function song(part)
    local bars = {}
    for _, chord in ipairs(CHORDS) do table.insert(bars, chord[part]) end
    return table.concat(bars, " ")
end

function sounds.load()
    clink = daft.sound { wave = "triangle", pitch = 1900, slide = 1700, attack = 0.001, decay = 0.09, volume = 0.5 }
    thud = daft.sound { wave = "noise", pitch = 90, slide = 40, attack = 0.001, decay = 0.14, cut = 500, volume = 1 }
    ring = daft.sound { notes = "e5 b5", beat = 0.09, decay = 0.25, volume = 0.4 }
    kick = daft.sound { wave = "square", pitch = 180, slide = 520, decay = 0.22, cut = 2500, volume = 0.4 }
    gem = daft.sound { notes = "b5 e6 g#6", beat = 0.06, decay = 0.3, volume = 0.4 }
    flag = daft.sound { wave = "triangle", notes = "a4 d5 f#5", beat = 0.1, decay = 0.35, volume = 0.5 }
    fall = daft.sound { wave = "saw", pitch = 420, slide = 70, decay = 0.7, cut = 1400, vibrato = 0.6, volume = 0.35 }
    leap = daft.sound { pitch = 240, slide = 520, decay = 0.16, volume = 0.35 }
    win = daft.sound { wave = "triangle", notes = "d5 d5 d5 f#5 e5 f#5 a5 - d6 - - -", beat = 0.12, decay = 0.5, volume = 0.5 }
    daft.volume("music", 0.35)
    daft.music(daft.sound { notes = song(1), beat = 0.21, decay = 0.7, volume = 0.3 })
    daft.sound { wave = "triangle", notes = song(2), beat = 0.21, attack = 0.02, decay = 0.9, cut = 700, volume = 0.6 }
        :play { loop = true, group = "music", fade = 1 }
    local rumble = daft.sound { wave = "noise", pitch = 60, attack = 0.05, hold = 2, decay = 0.05, cut = 260, volume = 1 }
    rolling = rumble:play { loop = true, volume = 0, near = 6 }
    before = { 0, 0, 0 }
end

-- Each tick: rolls as loud as the marble is fast, and rings where something has changed its way in one step.
function sounds.update(marble, on_ground)
    local vx, vy, vz = marble:velocity()
    local speed = math.sqrt(vx * vx + vz * vz)
    rolling:at(marble)
    rolling:volume(on_ground and math.min(1, speed / 9) * 0.3 or 0)
    rolling:pitch(0.6 + math.min(speed, 12) / 10)
    local jolt = math.sqrt((vx - before[1]) ^ 2 + (vy - before[2]) ^ 2 + (vz - before[3]) ^ 2)
    before[1], before[2], before[3] = vx, vy, vz
    if jolt > 1.2 then
        local loud = math.min(1, jolt / 7)
        thud:play { at = marble, volume = loud, near = 6 }
        clink:play { at = marble, volume = 0.5 * loud, near = 6, pitch = 0.9 + 0.2 * loud }
    end
end

function sounds.still() before[1], before[2], before[3] = 0, 0, 0 end -- it was put somewhere: that is no jolt
function sounds.bumper(place) kick:play { at = place, near = 8 } end
function sounds.gem(count) gem:play { pitch = 2 ^ (math.min(count, 12) / 24) } end
function sounds.checkpoint() flag:play() end
function sounds.fall() fall:play() end
function sounds.jump() leap:play() end
function sounds.win() win:play() end
function sounds.hint() ring:play() end

return sounds
