/* Plain lines of OBJ files (obj_scan.c) against the general reader, which sees the same lines with tabs for blanks: the
 * same bits, the same warnings, the same errors at the same places. */
#include "geometry/formats/obj.h"
#include "support_content.h"

enum { ROOM = 1 << 15 };

typedef struct script {
    char text[ROOM], tabs[ROOM];
    size_t size;
} script;

static void put(script *s, const char *text)
{
    size_t length = strlen(text);
    assert_true(s->size + length < ROOM);
    memcpy(s->text + s->size, text, length + 1);
    s->size += length;
}

static void put_digits(script *s, int count)
{
    for (; count > 0; count--) put(s, (char[2]){(char)('0' + random_below(10)), 0});
}

/* Mostly as exporters write them; sometimes long, bare, signed, with an exponent, or no number at all. */
static void put_number(script *s)
{
    uint32_t kind = random_below(40);
    if (kind == 0)
        put(s, "+");
    else if (random_below(2))
        put(s, "-");
    int before = kind < 4 ? (int)random_below(12) : (int)random_below(3), behind = kind < 8 ? (int)random_below(20) : 6;
    put_digits(s, before);
    if (kind != 1) put(s, ".");
    put_digits(s, behind + (before == 0));
    if (kind == 9) put(s, "e-3");
    if (kind == 10 && random_below(400) == 0) put(s, "x");
    if (kind == 11) put(s, "e+45");
}

static void put_blank(script *s) { put(s, random_below(60) ? " " : "  "); }

static void put_end(script *s)
{
    static const char *const ends[] = {"\n",   "\n",  "\n", "\n",       "\n",   "\n",
                                       "\r\n", " \n", "\r", " # why\n", "\n\n", " \\\n\n"};
    put(s, ends[random_below(random_below(4) ? 6 : DAFT_COUNT_OF(ends))]);
}

static void put_values(script *s, const char *keyword, int count)
{
    put(s, keyword);
    if (random_below(50) == 0) count += (int)random_below(40) ? 1 : -1;
    for (int i = 0; i < count; i++) put_blank(s), put_number(s);
    put_end(s);
}

static void put_index(script *s, uint32_t most)
{
    char text[32];
    int64_t index = (int64_t)random_below(most) + 1;
    if (random_below(300) == 0) index = -index;
    if (random_below(300) == 0) index = 0;
    if (random_below(20000) == 0) index *= 123456789;
    snprintf(text, sizeof text, random_below(20) ? "%lld" : "%04lld", (long long)index);
    put(s, text);
}

static void put_face(script *s, int form, uint32_t most)
{
    put(s, "f");
    if (random_below(100) == 0) form = (int)random_below(4);
    for (uint32_t left = random_below(60) ? 3 : 1 + random_below(6); left > 0; left--) {
        put_blank(s), put_index(s, most);
        if (form) put(s, "/");
        if (form & 1) put_index(s, most);
        if (form & 2) put(s, "/"), put_index(s, most);
    }
    put_end(s);
}

static void make_script(script *s, int lines)
{
    s->size = 0;
    int form = (int)random_below(4);
    bool sorted = random_below(2), broken = random_below(4) == 0;
    for (int i = 0; i < lines; i++) {
        uint32_t kind = sorted ? (uint32_t)(i * 5 / lines) : random_below(5);
        if (kind < 2) put_values(s, "v", 3);
        if (kind == 2) put_values(s, "vn", 3);
        if (kind == 3) put_values(s, "vt", 2);
        if (kind == 4) put_face(s, form, (uint32_t)lines / 6 + 3);
        if (random_below(40) == 0) put(s, random_below(2) ? "s 1\n" : "usemtl a\n");
        if (broken && random_below(100) == 0) put(s, random_below(2) ? "f 1 2 x\n" : "v 1 2\n");
    }
    for (size_t i = 0; i <= s->size; i++) s->tabs[i] = s->text[i] == ' ' ? '\t' : s->text[i];
}

typedef struct outcome {
    bool made;
    daft_obj obj;
    daft_error error;
    memo warnings;
} outcome;

static void run(const daft_allocator *allocator, const char *text, size_t size, outcome *out)
{
    daft_log log = memo_log(&out->warnings);
    memset(&out->obj, 0, sizeof out->obj);
    memset(&out->error, 0, sizeof out->error);
    out->made = daft_obj_parse(allocator, NULL, "a.obj", text, size, &log, &out->obj, &out->error);
}

static void same(const void *a, const void *b, size_t bytes, const char *what)
{
    if (!a != !b) fail_msg("only one has %s", what);
    if (a && memcmp(a, b, bytes) != 0) fail_msg("%s differ", what);
}

static void compare(const outcome *a, const outcome *b)
{
    assert_int_equal(a->made, b->made);
    assert_string_equal(a->error.message, b->error.message);
    assert_int_equal(a->error.line, b->error.line);
    assert_int_equal(a->error.column, b->error.column);
    assert_int_equal(a->warnings.count, b->warnings.count);
    for (int i = 0; i < a->warnings.count; i++) assert_string_equal(a->warnings.text[i], b->warnings.text[i]);
    const daft_trimesh *m = &a->obj.mesh, *n = &b->obj.mesh;
    assert_int_equal(m->vertex_count, n->vertex_count);
    assert_int_equal(m->triangle_count, n->triangle_count);
    assert_int_equal(m->normal_count, n->normal_count);
    assert_int_equal(m->uv_count, n->uv_count);
    size_t corners = 3 * (size_t)m->triangle_count, padded = ((size_t)m->vertex_count + 15) / 16 * 16;
    same(m->x, n->x, padded * sizeof(float), "x");
    same(m->y, n->y, padded * sizeof(float), "y");
    same(m->z, n->z, padded * sizeof(float), "z");
    same(m->indices, n->indices, corners * sizeof(uint32_t), "indices");
    same(m->normals, n->normals, m->normal_count * sizeof(daft_vec3), "normals");
    same(m->normal_indices, n->normal_indices, corners * sizeof(uint32_t), "indices of normals");
    same(m->uvs, n->uvs, m->uv_count * sizeof(daft_vec2), "uvs");
    same(m->uv_indices, n->uv_indices, corners * sizeof(uint32_t), "indices of uvs");
    same(m->slots, n->slots, m->triangle_count * sizeof(uint16_t), "slots");
    same(&m->low, &n->low, sizeof m->low, "low bounds");
    same(&m->high, &n->high, sizeof m->high, "high bounds");
}

static void plain_lines_are_read_as_all_others(void **unused)
{
    (void)unused;
    print_message("seed %llu\n", (unsigned long long)random_state);
    counting memory;
    daft_allocator allocator = counting_allocator(&memory);
    script *s = malloc(sizeof *s);
    outcome *outcomes = malloc(2 * sizeof *outcomes);
    assert_true(s && outcomes);
    int made = 0;
    for (int i = 0; i < 600; i++) {
        make_script(s, 5 + (int)random_below(250));
        run(&allocator, s->text, s->size, &outcomes[0]);
        run(&allocator, s->tabs, s->size, &outcomes[1]);
        compare(&outcomes[0], &outcomes[1]);
        for (int k = 0; k < 2; k++)
            if (outcomes[k].made) daft_obj_free(&allocator, &outcomes[k].obj);
        made += outcomes[0].made;
        assert_int_equal(memory.live, 0);
    }
    print_message("%d of 600 files were meshes\n", made);
    assert_in_range(made, 100, 599);
    free(s);
    free(outcomes);
}

/* Bytes of the line as the reader found it, and the numbers in it by strtod. */
static void numbers_have_the_bits_of_the_general_reader(void **unused)
{
    (void)unused;
    print_message("seed %llu\n", (unsigned long long)random_state);
    daft_allocator allocator = daft_malloc_allocator();
    daft_log log = {0};
    enum { LINES = 20000 };
    char *text = malloc(LINES * 96 + 200);
    assert_non_null(text);
    size_t used = 0;
    for (int i = 0; i < LINES; i++) {
        text[used++] = 'v';
        for (int k = 0; k < 3; k++) {
            int before = (int)random_below(9), behind = (int)random_below(9);
            used += (size_t)sprintf(text + used, random_below(2) ? " -" : " ");
            for (int d = 0; d < before; d++) text[used++] = (char)('0' + random_below(10));
            if (behind || !before || random_below(2)) text[used++] = '.';
            for (int d = 0; d < behind + !before; d++) text[used++] = (char)('0' + random_below(10));
        }
        text[used++] = '\n';
    }
    text[used] = 0;
    daft_obj_source source = {.text = daft_text_open("a.obj", text, used, &log), .allocator = &allocator};
    daft_error error;
    assert_true(daft_obj_read(&source, &error));
    assert_int_equal(source.position_count, LINES);
    const char *p = text;
    for (size_t i = 0; i < LINES; i++) {
        float wanted[3], found[3] = {source.x[i], source.y[i], source.z[i]};
        p++;
        for (int k = 0; k < 3; k++) {
            double value;
            p = daft_skip_blanks(p);
            assert_true(daft_scan_number(&p, text + used, &value));
            wanted[k] = (float)value;
        }
        if (memcmp(wanted, found, sizeof wanted) != 0) fail_msg("line %zu: %.20s", i + 1, p - 20);
        p++;
    }
    daft_obj_source_free(&source);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_lines_are_read_as_all_others),
        cmocka_unit_test(numbers_have_the_bits_of_the_general_reader),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
