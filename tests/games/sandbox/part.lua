return { value = 5 }
