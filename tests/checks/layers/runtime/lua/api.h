/* Public headers: api.h */
