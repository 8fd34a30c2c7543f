/* Reads Lua's bytecode: lundump.c, lopcodes.h of Lua 5.4. Registers are followed where control flow is straight. */
#include "cli/check/listing.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if LUA_VERSION_NUM == 504

enum { PATH = 128, REGISTERS = 256 };

/* Of lopcodes.h; what stands between the names is not looked at by itself. */
enum {
    OP_LFALSESKIP = 6,
    OP_SETUPVAL = 10,
    OP_GETTABUP = 11,
    OP_GETFIELD = 14,
    OP_SETTABUP = 15,
    OP_SETTABLE = 16,
    OP_SETI = 17,
    OP_SETFIELD = 18,
    OP_NEWTABLE = 19,
    OP_SELF = 20,
    OP_MMBIN = 46,
    OP_MMBINK = 48,
    OP_CLOSE = 54,
    OP_JMP = 56,
    OP_TEST = 66,
    OP_CALL = 68,
    OP_TAILCALL = 69,
    OP_RETURN = 70,
    OP_RETURN1 = 72,
    OP_FORLOOP = 73,
    OP_FORPREP = 74,
    OP_TFORPREP = 75,
    OP_TFORLOOP = 77,
    OP_SETLIST = 78,
    OP_EXTRAARG = 82
};

typedef struct reader {
    const uint8_t *at, *end;
    bool bad;
    listing_callback *found;
    void *user;
} reader;

/* A function's parts that matter, as they lie in the dump. */
typedef struct proto {
    const uint8_t *code; /* 4 bytes each, of this machine's order */
    uint64_t code_count;
    const char **constants; /* NULL: not a string */
    uint64_t constant_count;
    int first_line;
    const int8_t *lines;
    uint64_t line_count;
    uint64_t *absolute; /* pairs of place and line */
    uint64_t absolute_count;
    uint64_t environment; /* the upvalue that is _ENV; UINT64_MAX: none */
} proto;

/* ---- the dump ---- */

static const uint8_t *take(reader *r, uint64_t size)
{
    if (size > (uint64_t)(r->end - r->at)) r->bad = true;
    if (r->bad) return NULL;
    const uint8_t *at = r->at;
    r->at += size;
    return at;
}

static uint8_t take_byte(reader *r)
{
    const uint8_t *at = take(r, 1);
    return at ? *at : 0;
}

/* Seven bits a byte, the highest first; the last byte has its highest bit set. */
static uint64_t take_number(reader *r)
{
    uint64_t value = 0;
    for (int i = 0; i < 10 && !r->bad; i++) {
        const uint8_t byte = take_byte(r);
        value = value << 7 | (byte & 0x7f);
        if (byte & 0x80) return value;
    }
    r->bad = true;
    return 0;
}

/* Of things that have at least one byte each. */
static uint64_t take_count(reader *r)
{
    const uint64_t count = take_number(r);
    if (count > (uint64_t)(r->end - r->at)) r->bad = true;
    return r->bad ? 0 : count;
}

/* A copy that the caller frees; NULL: none, or out of memory. */
static char *take_string(reader *r)
{
    const uint64_t size = take_number(r);
    const uint8_t *bytes = size ? take(r, size - 1) : NULL;
    char *copy = bytes ? malloc(size) : NULL;
    if (!copy) return NULL;
    memcpy(copy, bytes, size - 1);
    copy[size - 1] = 0;
    return copy;
}

static void skip_string(reader *r)
{
    const uint64_t size = take_number(r);
    if (size) take(r, size - 1);
}

static void take_constants(reader *r, proto *p)
{
    enum { FLOAT = 0x13, INTEGER = 0x03, SHORT = 0x04, LONG = 0x14 };
    const uint64_t count = take_count(r);
    p->constants = calloc(count + 1, sizeof *p->constants);
    if (!p->constants) r->bad = true;
    for (uint64_t i = 0; i < count && !r->bad; i++) {
        p->constant_count = i + 1;
        const uint8_t type = take_byte(r);
        if (type == FLOAT || type == INTEGER) take(r, 8);
        if (type == SHORT || type == LONG) p->constants[i] = take_string(r);
    }
}

static void list_function(reader *r);

static void take_lines(reader *r, proto *p)
{
    p->line_count = take_count(r);
    p->lines = (const int8_t *)take(r, p->line_count);
    const uint64_t count = take_count(r);
    p->absolute = calloc(2 * count + 1, sizeof *p->absolute);
    if (!p->absolute) r->bad = true;
    for (uint64_t i = 0; i < 2 * count && !r->bad; i++) p->absolute[i] = take_number(r);
    p->absolute_count = r->bad ? 0 : count;
}

static void take_names(reader *r, proto *p)
{
    const uint64_t locals = take_count(r);
    for (uint64_t i = 0; i < locals && !r->bad; i++) {
        skip_string(r);
        take_number(r);
        take_number(r);
    }
    const uint64_t upvalues = take_count(r);
    p->environment = UINT64_MAX;
    for (uint64_t i = 0; i < upvalues && !r->bad; i++) {
        char *name = take_string(r);
        if (name && strcmp(name, "_ENV") == 0) p->environment = i;
        free(name);
    }
}

/* ---- the code ---- */

static uint32_t word_at(const proto *p, uint64_t at)
{
    uint32_t word;
    memcpy(&word, p->code + 4 * at, sizeof word);
    return word;
}

static unsigned op_of(uint32_t word) { return word & 0x7f; }
static unsigned a_of(uint32_t word) { return word >> 7 & 0xff; }
static unsigned b_of(uint32_t word) { return word >> 16 & 0xff; }
static unsigned c_of(uint32_t word) { return word >> 24; }

static const char *constant(const proto *p, unsigned index)
{
    return index < p->constant_count ? p->constants[index] : NULL;
}

static int line_of(const proto *p, uint64_t at)
{
    int line = p->first_line;
    for (uint64_t i = 0; i <= at && i < p->line_count; i++) {
        if (p->lines[i] != -128) {
            line += p->lines[i];
            continue;
        }
        for (uint64_t k = 0; k < p->absolute_count; k++)
            if (p->absolute[2 * k] == i) line = (int)p->absolute[2 * k + 1];
    }
    return line;
}

/* Where control comes from elsewhere, a register may hold something else. */
static void mark_target(uint8_t *targets, uint64_t count, int64_t at)
{
    if (at >= 0 && (uint64_t)at < count) targets[at] = 1;
}

static uint8_t *find_targets(const proto *p)
{
    uint8_t *targets = calloc(p->code_count + 1, 1);
    for (uint64_t i = 0; targets && i < p->code_count; i++) {
        const uint32_t word = word_at(p, i);
        const int64_t next = (int64_t)i + 1, far = word >> 15;
        switch (op_of(word)) {
        case OP_JMP: mark_target(targets, p->code_count, next + (int64_t)(word >> 7) - 0xffffff); break;
        case OP_FORLOOP:
        case OP_TFORLOOP: mark_target(targets, p->code_count, next - far); break;
        case OP_FORPREP: mark_target(targets, p->code_count, next + far + 1); break;
        case OP_TFORPREP: mark_target(targets, p->code_count, next + far); break;
        case OP_LFALSESKIP: mark_target(targets, p->code_count, next + 1); break;
        default: break;
        }
    }
    return targets;
}

static bool writes_register(unsigned op)
{
    return !(op == OP_SETUPVAL || (op >= OP_SETTABUP && op <= OP_SETFIELD) || (op >= OP_MMBIN && op <= OP_MMBINK) ||
             (op >= OP_CLOSE && op <= OP_TEST) || (op >= OP_RETURN && op <= OP_RETURN1) || op == OP_SETLIST ||
             op == OP_EXTRAARG);
}

typedef struct option {
    const char *name;
    unsigned table;
    int line;
} option;

/* What registers hold: a global or a field of one, by its path; or a new table behind it, as in PATH{…}. Empty:
 * something else. Fields of such tables wait for the call. */
typedef struct registers {
    char path[REGISTERS + 1][PATH], table[REGISTERS + 1][PATH];
    option options[REGISTERS];
    unsigned option_count;
} registers;

static void forget_from(registers *known, unsigned first)
{
    unsigned kept = 0;
    for (unsigned i = first; i < REGISTERS; i++) known->path[i][0] = known->table[i][0] = 0;
    for (unsigned i = 0; i < known->option_count; i++)
        if (known->options[i].table < first) known->options[kept++] = known->options[i];
    known->option_count = kept;
}

/* A call of register a with one argument, the table after it. */
static void list_options(const reader *r, const registers *known, unsigned a)
{
    for (unsigned i = 0; i < known->option_count; i++)
        if (known->options[i].table == a + 1)
            r->found(r->user, LISTING_OPTION, known->table[a + 1], known->options[i].name, known->options[i].line);
}

static void list_instruction(reader *r, const proto *p, registers *known, uint64_t at)
{
    const uint32_t word = word_at(p, at);
    const unsigned op = op_of(word), a = a_of(word), b = b_of(word), c = c_of(word);
    char path[PATH] = "", table[PATH] = "";
    const char *name = constant(p, op == OP_GETTABUP || op == OP_GETFIELD || op == OP_SELF ? c : b);
    if (op == OP_GETTABUP && b == p->environment && name) {
        snprintf(path, sizeof path, "%s", name);
        r->found(r->user, LISTING_READ, path, name, line_of(p, at));
    } else if (op == OP_GETFIELD && known->path[b][0] && name) {
        if (snprintf(path, sizeof path, "%s.%s", known->path[b], name) >= PATH) path[0] = 0;
        if (path[0]) r->found(r->user, LISTING_READ, path, name, line_of(p, at));
    } else if (op == OP_SETTABUP && a == p->environment && name) {
        r->found(r->user, LISTING_SET, name, name, line_of(p, at));
    } else if (op == OP_SETFIELD && name && known->table[a][0]) {
        if (known->option_count < REGISTERS) known->options[known->option_count++] = (option){name, a, line_of(p, at)};
    } else if (op == OP_SETFIELD && name && known->path[a][0]) {
        if (snprintf(path, sizeof path, "%s.%s", known->path[a], name) < PATH)
            r->found(r->user, LISTING_SET, path, name, line_of(p, at));
        path[0] = 0;
    } else if (op == OP_SELF && name && (word >> 15 & 1)) {
        r->found(r->user, LISTING_METHOD, known->path[b], name, line_of(p, at));
    } else if ((op == OP_CALL || op == OP_TAILCALL) && b == 2) {
        list_options(r, known, a);
    } else if (op == OP_NEWTABLE && a > 0) {
        snprintf(table, sizeof table, "%s", known->path[a - 1]);
    }
    const bool of_upvalue = op == OP_SETTABUP && a != p->environment;
    if (name && (of_upvalue || (op == OP_SETFIELD && !known->table[a][0])))
        r->found(r->user, LISTING_FIELD, "", name, line_of(p, at));
    if (!writes_register(op)) return;
    forget_from(known, a);
    memcpy(known->path[a], path, sizeof path);
    memcpy(known->table[a], table, sizeof table);
}

static void list_code(reader *r, const proto *p)
{
    registers *known = calloc(1, sizeof *known);
    uint8_t *targets = find_targets(p);
    if (!known || !targets) r->bad = true;
    for (uint64_t i = 0; i < p->code_count && !r->bad; i++) {
        if (targets[i]) /* a table that is being made stays in its register over what its fields jump */
            for (unsigned k = 0; k < REGISTERS; k++) known->path[k][0] = 0;
        list_instruction(r, p, known, i);
    }
    free(targets);
    free(known);
}

/* ---- functions ---- */

static void list_function(reader *r)
{
    proto p = {0};
    skip_string(r); /* the source */
    p.first_line = (int)take_number(r);
    take_number(r); /* the last line */
    take(r, 3);     /* parameters, whether there are more, registers */
    p.code_count = take_count(r);
    p.code = take(r, 4 * p.code_count);
    take_constants(r, &p);
    take(r, 3 * take_count(r)); /* upvalues */
    const uint64_t inner = take_count(r);
    for (uint64_t i = 0; i < inner && !r->bad; i++) list_function(r);
    if (!r->bad) take_lines(r, &p);
    if (!r->bad) take_names(r, &p);
    if (!r->bad) list_code(r, &p);
    for (uint64_t i = 0; i < p.constant_count; i++) free((void *)(uintptr_t)p.constants[i]);
    free(p.constants);
    free(p.absolute);
}

typedef struct buffer {
    uint8_t *bytes;
    size_t size;
} buffer;

static int keep(lua_State *L, const void *bytes, size_t size, void *user)
{
    (void)L;
    buffer *out = user;
    uint8_t *grown = realloc(out->bytes, out->size + size + 1);
    if (!grown) return 1;
    memcpy(grown + out->size, bytes, size);
    out->bytes = grown, out->size += size;
    return 0;
}

bool listing_read(lua_State *L, listing_callback *found, void *user)
{
    /* The mark, the version, the format, LUAC_DATA, and the sizes of what is dumped; then a number of each kind. */
    static const uint8_t HEAD[] = {0x1b, 'L', 'u', 'a', 0x54, 0, 0x19, 0x93, '\r', '\n', 0x1a, '\n', 4, 8, 8};
    buffer dump = {0};
    bool good =
        lua_dump(L, keep, &dump, 0) == 0 && dump.size > sizeof HEAD && memcmp(dump.bytes, HEAD, sizeof HEAD) == 0;
    if (good) {
        reader r = {.at = dump.bytes + sizeof HEAD, .end = dump.bytes + dump.size, .found = found, .user = user};
        take(&r, 8 + 8 + 1); /* the numbers; how many upvalues */
        list_function(&r);
        good = !r.bad;
    }
    free(dump.bytes);
    return good;
}

#else

bool listing_read(lua_State *L, listing_callback *found, void *user)
{
    (void)L, (void)found, (void)user;
    return false;
}

#endif
