-- daft.load: the width of a long text
function daft.load() local s = ("Wo"):rep(8000) while true do daft.text_width(s, 300) end end
