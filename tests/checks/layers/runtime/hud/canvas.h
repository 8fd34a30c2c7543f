/* expect: rooms name their public headers */
