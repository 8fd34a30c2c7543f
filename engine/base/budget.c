/* The budget of bytes: see budget.h. */
#include "base/budget.h"

#include <stdatomic.h>
#include <stdio.h>

struct daft_budget {
    daft_allocator from;
    uint64_t limit; /* UINT64_MAX: none */
    atomic_ullong peak;
    atomic_int calling;              /* calls of `from` that run now, on any thread */
    _Alignas(64) atomic_ullong used; /* includes this struct, until the budget is closed */
};

/* In front of each block, as far as its alignment asks for, at most 64 bytes. */
typedef struct header {
    size_t size, offset; /* bytes: of the whole allocation; from its beginning to the block */
} header;

static void raise_peak(daft_budget *budget, unsigned long long used)
{
    unsigned long long peak = atomic_load_explicit(&budget->peak, memory_order_relaxed);
    while (peak < used && !atomic_compare_exchange_weak_explicit(&budget->peak, &peak, used, memory_order_relaxed,
                                                                 memory_order_relaxed)) {
    }
}

bool daft_budget_take(daft_budget *budget, uint64_t bytes)
{
    unsigned long long used = atomic_load_explicit(&budget->used, memory_order_relaxed);
    do
        if (bytes > budget->limit - used) return false;
    while (!atomic_compare_exchange_weak_explicit(&budget->used, &used, used + bytes, memory_order_relaxed,
                                                  memory_order_relaxed));
    raise_peak(budget, used + bytes);
    return true;
}

/* Who gives back the last bytes frees the budget: they are its own, which closing gives back, or a block's that
 * outlived the engine. */
void daft_budget_give(daft_budget *budget, uint64_t bytes)
{
    if (atomic_fetch_sub_explicit(&budget->used, bytes, memory_order_acq_rel) != bytes) return;
    daft_allocator from = budget->from;
    daft_release(&from, budget);
}

static void *budget_allocate(void *user, size_t size, size_t alignment)
{
    daft_budget *budget = user;
    size_t offset = alignment < sizeof(header) ? sizeof(header) : alignment, bytes;
    if (__builtin_add_overflow(size, offset, &bytes) || !daft_budget_take(budget, bytes)) return NULL;
    atomic_fetch_add_explicit(&budget->calling, 1, memory_order_relaxed);
    char *memory = budget->from.allocate(budget->from.user, bytes, alignment);
    atomic_fetch_sub_explicit(&budget->calling, 1, memory_order_relaxed);
    if (!memory) {
        daft_budget_give(budget, bytes);
        return NULL;
    }
    ((header *)(void *)(memory + offset))[-1] = (header){bytes, offset};
    return memory + offset;
}

static void budget_release(void *user, void *pointer)
{
    if (!pointer) return;
    daft_budget *budget = user;
    header held = ((header *)pointer)[-1];
    atomic_fetch_add_explicit(&budget->calling, 1, memory_order_relaxed);
    budget->from.release(budget->from.user, (char *)pointer - held.offset);
    atomic_fetch_sub_explicit(&budget->calling, 1, memory_order_relaxed);
    daft_budget_give(budget, held.size);
}

daft_budget *daft_budget_open(const daft_allocator *from, uint64_t limit)
{
    if (limit && limit < sizeof(daft_budget)) return NULL;
    daft_budget *budget = daft_alloc(from, 1, sizeof *budget);
    if (!budget) return NULL;
    budget->from = *from;
    budget->limit = limit ? limit : UINT64_MAX;
    atomic_init(&budget->used, sizeof *budget);
    atomic_init(&budget->peak, sizeof *budget);
    atomic_init(&budget->calling, 0);
    return budget;
}

void daft_budget_close(daft_budget *budget)
{
    if (budget) daft_budget_give(budget, sizeof *budget);
}

bool daft_budget_is_calling(const daft_budget *budget)
{
    return atomic_load_explicit(&budget->calling, memory_order_relaxed) != 0;
}

daft_allocator daft_budget_allocator(daft_budget *budget)
{
    return (daft_allocator){budget, budget_allocate, budget_release};
}

daft_memory daft_budget_memory(const daft_budget *budget)
{
    return (daft_memory){.used = atomic_load_explicit(&budget->used, memory_order_relaxed),
                         .peak = atomic_load_explicit(&budget->peak, memory_order_relaxed),
                         .limit = budget->limit == UINT64_MAX ? 0 : budget->limit};
}

/* "1.43 GB", "12 kB": three digits are enough to see what is too much. */
static const char *bytes_text(uint64_t bytes, char out[32])
{
    static const char *const units[] = {"bytes", "kB", "MB", "GB", "TB"};
    double value = (double)bytes;
    size_t unit = 0;
    for (; value >= 999.5 && unit + 1 < DAFT_COUNT_OF(units); unit++) value /= 1000;
    snprintf(out, 32, "%.3g %s", value, units[unit]);
    return out;
}

bool daft_budget_allows(const daft_allocator *allocator, uint64_t bytes, const char *path, const char *what,
                        daft_error *error)
{
    if (allocator->allocate != budget_allocate) return true;
    const daft_budget *budget = allocator->user;
    daft_memory memory = daft_budget_memory(budget);
    if (!memory.limit || bytes <= memory.limit - memory.used) return true;
    char need[32], limit[32], used[32];
    return daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0,
                        "%s needs %s of memory; the limit is %s, of which %s are in use", what, bytes_text(bytes, need),
                        bytes_text(memory.limit, limit), bytes_text(memory.used, used));
}
