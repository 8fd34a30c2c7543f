/* Public headers: cost.h */
