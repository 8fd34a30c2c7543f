/* What a world is made of. Not the first comment that counts: this room's list is in sim.h.
 * Inner headers: world.h */
