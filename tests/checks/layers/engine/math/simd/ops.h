/* Public headers: ops.h */
