for _, f in ipairs { function() return ("").rep("", 1 << 62) end, function() table.move({}, 1, 1 << 62, 2) end,
  function() table.insert(setmetatable({}, { __len = function() return 1 << 61 end }), 1, 0) end } do print(pcall(f)) end
