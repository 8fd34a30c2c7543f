-- main.lua: a loop outside of every function
while true do end
