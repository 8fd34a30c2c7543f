/* Public headers: sim.h query/query.h missing.h expect: listed headers exist */
