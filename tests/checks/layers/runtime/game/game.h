/* Public headers: game.h */
