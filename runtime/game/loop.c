/* The fixed time step. */
#include "game/loop.h"

static const uint64_t UPDATE = 1000000000u; /* one update, in units of 1/60 ns */

int loop_advance(loop *state, uint64_t elapsed_ns)
{
    /* At most an hour, so that the product cannot overflow after a night in suspend. */
    const uint64_t longest = (uint64_t)3600 * 1000000000u;
    if (elapsed_ns > longest) elapsed_ns = longest;
    state->owed += elapsed_ns * LOOP_RATE;
    uint64_t updates = state->owed / UPDATE;
    state->owed %= UPDATE;
    if (updates > LOOP_MAX_UPDATES) {
        state->dropped += updates - LOOP_MAX_UPDATES;
        updates = LOOP_MAX_UPDATES;
    }
    return (int)updates;
}

float loop_alpha(const loop *state)
{
    /* owed < UPDATE, but the quotient may round up to 1 in float. */
    float alpha = (float)((double)state->owed / (double)UPDATE);
    return alpha < 1 ? alpha : 0x1.fffffep-1f;
}
