/* Public headers: platform.h. expect: rooms are on the map */
