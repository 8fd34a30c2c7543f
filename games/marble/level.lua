-- The course as data. Metres; x leads away from the start, y is up, z is to the right.
-- Heights are those of the surface one rolls on.

return {
    start = { 0, 0, 0 },
    gems_needed = 6,
    lowest = -8, -- this far below the last checkpoint the marble has fallen

    -- Straight pieces between two points on the surface. Slopes, turns and all lie in the two points.
    -- look: see course.lua. kerbs: low walls along both sides.
    roads = {
        { from = { -5, 0, 0 }, to = { 5, 0, 0 }, width = 9, look = "tiles" },
        { from = { 5, 0, 0 }, to = { 12, 0, 0 }, width = 4, look = "tiles", kerbs = true },
        { from = { 12, 0, 0 }, to = { 21, -2.6, 0 }, width = 4, look = "arrows", kerbs = true },
        { from = { 21, -2.6, 0 }, to = { 32, -2.6, 0 }, width = 9, look = "stone" },
        { from = { 29.5, -2.6, 4.5 }, to = { 29.5, -2.6, 12 }, width = 3, look = "tiles" },
        -- a gap to jump
        { from = { 29.5, -2.9, 15 }, to = { 29.5, -2.9, 23 }, width = 6, look = "tiles" },
        { from = { 32.5, -2.9, 20.5 }, to = { 43, -2.9, 20.5 }, width = 1.4, look = "wood" },
        { from = { 43, -2.9, 20.5 }, to = { 49, -2.9, 20.5 }, width = 6, look = "tiles" },
        -- a platform goes to and fro here
        { from = { 60, -2.9, 20.5 }, to = { 63, -2.9, 20.5 }, width = 4, look = "tiles" },
        { from = { 63, -2.9, 20.5 }, to = { 72, 0, 20.5 }, width = 4, look = "arrows", kerbs = true },
        { from = { 72, 0, 20.5 }, to = { 88, 0, 20.5 }, width = 9, look = "marble" },
    },

    -- Boxes that glide to and fro between two points. `period`: seconds there and back.
    platforms = {
        { size = { 3.6, 0.5, 3.6 }, from = { 51, -2.9, 20.5 }, to = { 58, -2.9, 20.5 }, period = 6 },
    },

    -- Arms that turn on the spot, in radians a second. Wait for the gap, or jump.
    sweepers = { { at = { 76.3, 0, 20.5 }, length = 6.4, speed = 1.5 } },

    -- They push the marble away.
    bumpers = { { 24.5, -2.6, -1.9 }, { 24.5, -2.6, 1.9 }, { 27.5, -2.6, 0 } },

    gems = {
        { 8.5, 0, 0 }, { 16.5, -1.3, 0 }, { 27, -2.6, 2.6 }, { 29.5, -2.6, 8 }, { 29.5, -1.4, 13.5 },
        { 37.5, -2.9, 20.5 }, { 54.5, -2.9, 20.5 }, { 67.5, -1.45, 20.5 },
    },

    -- Reaching one makes it the place to come back to.
    checkpoints = { { 29.5, -2.9, 17.5 }, { 46, -2.9, 20.5 } },

    goal = { 83, 0, 20.5 },

    -- mesh, place, then scale and turn (degrees) where wanted.
    scenery = {
        { "column", { -4.3, 0, -3.8 } }, { "column", { -4.3, 0, 3.8 } },
        { "column", { 4.3, 0, -3.8 } }, { "column", { 4.3, 0, 3.8 } },
        { "column", { 73, 0, 16.6 } }, { "column", { 73, 0, 24.4 } },
        { "column", { 80, 0, 16.6 } }, { "column", { 80, 0, 24.4 } },
        { "column", { 87, 0, 16.6 } }, { "column", { 87, 0, 24.4 } },
        { "cup", { 86.3, 0, 20.5 }, 1.6, 90 },
        { "flag", { 48.5, -2.9, 18 }, 1, 30 }, { "flag", { 32, -2.9, 15.6 }, 1, 60 },
        { "island", { 11, -5, -9 }, 1.3 }, { "tree", { 10, -5, -8 }, 1.6 }, { "pine", { 12.6, -5, -10 }, 1.5 },
        { "rock", { 12.4, -5, -7 }, 1, 70 },
        { "island", { 17, -7, 12 }, 1.6, 80 }, { "pine", { 16, -7, 11 }, 2 }, { "pine", { 18.5, -7, 13.4 }, 1.6, 20 },
        { "tree", { 19.4, -7, 10.4 }, 1.7 },
        { "island", { 42, -6.5, 9 }, 1.4, 150 }, { "tree", { 42, -6.5, 9 }, 2.1 }, { "rock", { 44, -6.5, 8 }, 1.4 },
        { "island", { 41, -7, 31 }, 1.2, 200 }, { "pine", { 41, -7, 31 }, 2.2 }, { "pine", { 39.4, -7, 32 }, 1.4, 50 },
        { "island", { 55, -5, 33 }, 1.5, 30 }, { "tree", { 54, -5, 32.5 }, 1.9, 80 }, { "pine", { 57, -5, 34 }, 1.8 },
        { "island", { 66, -5, 9 }, 1.2, 110 }, { "pine", { 66, -5, 9 }, 2 }, { "rock", { 64.5, -5, 10 }, 1.2 },
        { "island", { 92, -3, 33 }, 2, 10 }, { "tree", { 92, -3, 33 }, 2.6 }, { "pine", { 95, -3, 31 }, 2.4 },
        { "island", { 96, -1, 12 }, 1.7, 60 }, { "pine", { 96, -1, 12 }, 2.6 }, { "tree", { 94, -1, 10.5 }, 1.6 },
    },
}
