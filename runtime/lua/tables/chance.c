/* Random numbers and noise: the game's own sequence, further ones, and simplex noise. */
#include "lua/api.h"

#include "common/util.h"

#include <math.h>

/* ---- random numbers ---- */

/* 0 .. span, each equally likely: values of the smallest mask that holds the span, until one fits. */
static uint64_t pick(random_state *state, uint64_t span)
{
    uint64_t mask = span;
    for (int shift = 1; shift < 64; shift *= 2) mask |= mask >> shift;
    uint64_t value;
    do value = random_next(state) & mask;
    while (value > span);
    return value;
}

/* [m [, n]] from `index` on. */
static int push_random(lua_State *L, host *h, random_state *state, int index)
{
    const int count = lua_gettop(L) - index + 1;
    if (count <= 0) {
        lua_pushnumber(L, (double)(random_next(state) >> 11) * 0x1p-53);
        return 1;
    }
    lua_Integer low = count > 1 ? api_whole(L, h, index, "low") : 1;
    lua_Integer high = api_whole(L, h, count > 1 ? index + 1 : index, "high");
    if (low > high)
        api_error(L, h, "high: a number of %lld or more expected, got %lld", (long long)low, (long long)high);
    lua_pushinteger(L, (lua_Integer)((uint64_t)low + pick(state, (uint64_t)high - (uint64_t)low)));
    return 1;
}

static int random_number(lua_State *L, host *h)
{
    return push_random(L, h, h->picture ? &h->draw_random : &h->random, 1);
}

static int random_reseed(lua_State *L, host *h)
{
    random_seed(&h->random, lua_isnone(L, 1) ? h->def.seed : (uint64_t)api_whole(L, h, 1, "seed"));
    return 0;
}

typedef struct stream {
    api_handle handle; /* first: see api_set_type */
    random_state state;
} stream;

static int new_stream(lua_State *L, host *h)
{
    const uint64_t seed = (uint64_t)api_whole(L, h, 1, "seed");
    stream *made = lua_newuserdatauv(L, sizeof *made, 0);
    *made = (stream){.handle.id = ++h->streams};
    random_seed(&made->state, seed);
    api_set_type(L, API_STREAM);
    return 1;
}

static stream *stream_at(lua_State *L, host *h) { return (stream *)api_check_handle(L, h, 1, API_STREAM, "stream"); }

static int stream_random(lua_State *L, host *h) { return push_random(L, h, &stream_at(L, h)->state, 2); }

static int stream_seed(lua_State *L, host *h)
{
    random_seed(&stream_at(L, h)->state, (uint64_t)api_whole(L, h, 2, "seed"));
    return 0;
}

/* ---- noise ----
 *
 * Simplex noise (Perlin 2001; the explanation is Gustavson's, 2005) in one to four dimensions by one algorithm. Space
 * is skewed so that a grid of cubes becomes one of simplices; each corner of the simplex around a point has a gradient,
 * chosen by a hash of its coordinates, which acts within a ball that no other simplex's face cuts: 0.5 for the square
 * of its radius, 1 in one dimension. */

enum { DIMENSIONS = 4 };

/* Murmur3's finaliser over the coordinates, each times an odd number of its own. */
static uint32_t hash_corner(const int64_t *at, int dimensions)
{
    static const uint32_t ODD[DIMENSIONS] = {0x9E3779B1u, 0x85EBCA77u, 0xC2B2AE3Du, 0x27D4EB2Fu};
    uint32_t h = 0x165667B1u;
    for (int k = 0; k < dimensions; k++) h = (h ^ (uint32_t)(uint64_t)at[k] * ODD[k]) * 0x2C1B3C6Du, h ^= h >> 15;
    h ^= h >> 16, h *= 0x85EBCA6Bu, h ^= h >> 13, h *= 0xC2B2AE35u, h ^= h >> 16;
    return h;
}

/* The gradient times the displacement. Gradients are slopes of ±1/8 to ±1; eight directions; the middles of a cube's 12
 * edges; of a hypercube's 32. */
static double gradient(uint32_t hash, const double *d, int dimensions)
{
    static const double HALF = 0.70710678118654752;
    if (dimensions == 1) return (hash & 8 ? -1 : 1) * (1 + (double)(hash & 7)) / 8 * d[0];
    const double a = hash & 1 ? -1 : 1, b = hash & 2 ? -1 : 1, c = hash & 4 ? -1 : 1;
    if (dimensions == 2) {
        if (hash & 4) return HALF * (a * d[0] + b * d[1]);
        return a * d[b > 0 ? 0 : 1];
    }
    const uint32_t missing = (hash >> 8) % (uint32_t)dimensions;
    const double signs[3] = {a, b, c};
    double sum = 0;
    for (int k = 0, i = 0; k < dimensions; k++)
        if ((uint32_t)k != missing) sum += signs[i++] * d[k];
    return sum * (dimensions == 3 ? HALF : 0.57735026918962576);
}

/* How many coordinates of the point within its cube are larger: the order in which a simplex's corners step. */
static void rank_coordinates(const double *x, int dimensions, int *rank)
{
    for (int k = 0; k < dimensions; k++) rank[k] = 0;
    for (int k = 0; k < dimensions; k++)
        for (int j = k + 1; j < dimensions; j++) rank[x[k] > x[j] ? j : k]++;
}

static double noise_at(const double *x, int n)
{
    static const double SCALE[DIMENSIONS + 1] = {0, 3.16, 99.2, 108.7,
                                                 108.7} /* one over the largest sums that were found */;
    const double root = sqrt(n + 1.0), skew = (root - 1) / n, unskew = (1 - 1 / root) / n;
    double sum = 0, slide = 0, first[DIMENSIONS], total = 0;
    int64_t cell[DIMENSIONS];
    int rank[DIMENSIONS];
    for (int k = 0; k < n; k++) slide += x[k];
    for (int k = 0; k < n; k++) {
        cell[k] = (int64_t)floor(x[k] + (n > 1 ? slide * skew : 0));
        total += (double)cell[k];
    }
    for (int k = 0; k < n; k++) first[k] = x[k] - ((double)cell[k] - (n > 1 ? total * unskew : 0));
    rank_coordinates(first, n, rank);
    for (int corner = 0; corner <= n; corner++) {
        double d[DIMENSIONS], reach = n == 1 ? 1 : 0.5;
        int64_t at[DIMENSIONS];
        for (int k = 0; k < n; k++) {
            const int step = rank[k] < corner;
            at[k] = cell[k] + step;
            d[k] = first[k] - step + (n > 1 ? corner * unskew : 0);
            reach -= d[k] * d[k];
        }
        if (reach > 0) sum += reach * reach * reach * reach * gradient(hash_corner(at, n), d, n);
    }
    return fmax(-1, fmin(1, sum * SCALE[n]));
}

static int noise(lua_State *L, host *h)
{
    static const char *const NAMES[DIMENSIONS] = {"x", "y", "z", "w"};
    double x[DIMENSIONS];
    int count = lua_gettop(L);
    if (count < 1 || count > DIMENSIONS) api_error(L, h, "1 to %d numbers expected, got %d", (int)DIMENSIONS, count);
    for (int k = 0; k < count; k++) {
        x[k] = api_number(L, h, k + 1, NAMES[k]);
        if (!(fabs(x[k]) <= 1e12)) api_wrong(L, h, k + 1, NAMES[k], "number within 1e12");
    }
    lua_pushnumber(L, noise_at(x, count));
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"random", "([m [, n]]) -> number",
     "0 <= x < 1; or a whole number from 1 to m, or from m to n. The same in every run with the same seed;\n"
     "math.random is the same function. Within daft.draw it draws from a sequence of its own.",
     random_number, 0},
    {"randomseed", "([seed])", "Starts the sequence again; math.randomseed is the same function.", random_reseed,
     API_CHANGES},
    {"random_stream", "(seed) -> stream", "A sequence of random numbers of its own, which no other call disturbs.",
     new_stream, 0},
    {"stream:random", "([m [, n]]) -> number", "As daft.random, from this sequence.", stream_random, 0},
    {"stream:seed", "(seed)", "Starts the sequence again.", stream_seed, 0},
    {"noise", "(x [, y [, z [, w]]]) -> number",
     "Smooth noise between -1 and 1 in one to four dimensions, with one bump for each unit, about 0 on average.", noise,
     0},
};

const api_area api_chance = {"Random numbers and noise", FUNCTIONS, COUNT_OF(FUNCTIONS)};
