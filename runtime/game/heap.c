/* A heap in one range of addresses. Blocks have sizes of a few classes, four to each power of two, and go to the list
 * of their class when they are released; what was never in use lies above `top`. All of that stands in the range
 * itself, so that it goes back in time with the rest. */
#include "game/heap.h"

#include "common/util.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { PAGE = 4096, CLASSES = 130, SMALLEST = 32 };

/* ---- the range ---- */

typedef struct free_block {
    struct free_block *next;
} free_block;

/* At the beginning of the range. */
typedef struct range {
    size_t top; /* bytes in use from the beginning */
    free_block *released[CLASSES];
} range;

/* In front of each block; its size is the least alignment. */
typedef struct header {
    uint32_t class, offset; /* offset: from the memory taken to the block */
    uint64_t unused;
} header;

typedef struct page {
    uint32_t holders; /* images; 0: free */
    struct page *next_free;
    _Alignas(64) unsigned char bytes[PAGE];
} page;

struct heap_image {
    size_t count;
    page *pages[];
};

struct heap {
    pthread_mutex_t lock; /* of the range's lists */
    unsigned char *base;
    size_t size;
    daft_allocator allocator;
    page *free_pages;
    size_t held_pages;        /* in images */
    size_t listed_pages;      /* the same, once for each image that has them */
    const heap_image *latest; /* the image that the range is most like, or NULL */
};

static size_t round_up(size_t value, size_t step) { return (value + step - 1) / step * step; }

/* 32 and 48, then four to an octave: 64, 80, 96, 112, 128, 160… */
static size_t size_of_class(uint32_t class)
{
    return class < 2 ? SMALLEST + 16 * (size_t) class : (size_t)(4 + (class - 2) % 4) << ((class - 2) / 4 + 4);
}

/* The least class that holds so many bytes. */
static uint32_t class_of(size_t size)
{
    if (size <= 48) return size > SMALLEST;
    const size_t last = (size - 1) >> 4; /* 64 and less: below 4 */
    if (last < 4) return 2;
    const int octave = 61 - __builtin_clzll((unsigned long long)last); /* of 4…7: 0 */
    return 2 + 4 * (uint32_t)octave + (uint32_t)(last >> octave) - 4 + 1;
}

static unsigned char *take(heap *self, uint32_t class)
{
    range *r = (range *)(void *)self->base;
    free_block *old = r->released[class];
    if (old) {
        r->released[class] = old->next;
        return (unsigned char *)old;
    }
    const size_t size = size_of_class(class);
    if (size > self->size - r->top) return NULL;
    r->top += size;
    return self->base + r->top - size;
}

static void *heap_allocate(void *user, size_t size, size_t alignment)
{
    heap *self = user;
    const size_t extra = alignment > sizeof(header) ? alignment : sizeof(header);
    if (size > self->size) return NULL;
    const uint32_t class = class_of(size + extra);
    pthread_mutex_lock(&self->lock);
    unsigned char *memory = class < CLASSES ? take(self, class) : NULL;
    pthread_mutex_unlock(&self->lock);
    if (!memory) return NULL;
    /* Memory is aligned to 16 bytes, the header's size, so that it fits in front of any alignment. */
    unsigned char *block = self->base + round_up((size_t)(memory - self->base) + sizeof(header), alignment);
    *(header *)(void *)(block - sizeof(header)) = (header){class, (uint32_t)(block - memory), 0};
    return block;
}

static void heap_release(void *user, void *pointer)
{
    heap *self = user;
    if (!pointer) return;
    const header *h = (const header *)(const void *)((unsigned char *)pointer - sizeof(header));
    const uint32_t class = h->class;
    free_block *block = (free_block *)(void *)((unsigned char *)pointer - h->offset);
    range *r = (range *)(void *)self->base;
    pthread_mutex_lock(&self->lock);
    block->next = r->released[class];
    r->released[class] = block;
    pthread_mutex_unlock(&self->lock);
}

heap *heap_open(uint64_t most, daft_error *error)
{
    heap *self = calloc(1, sizeof *self);
    void *base =
        self ? mmap(NULL, (size_t)most, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)
             : MAP_FAILED;
    if (base == MAP_FAILED) {
        free(self);
        fail(error, DAFT_ERROR_MEMORY, "out of memory, or of addresses, for a game's past");
        return NULL;
    }
    pthread_mutex_init(&self->lock, NULL);
    self->base = base, self->size = (size_t)most;
    ((range *)base)->top = round_up(sizeof(range), 64);
    self->allocator = (daft_allocator){self, heap_allocate, heap_release};
    return self;
}

const daft_allocator *heap_allocator(const heap *self) { return &self->allocator; }
uint64_t heap_used(const heap *self) { return ((const range *)(const void *)self->base)->top; }
uint64_t heap_image_bytes(const heap *self)
{
    return (uint64_t)self->held_pages * sizeof(page) + (uint64_t)self->listed_pages * sizeof(page *);
}

/* ---- images ---- */

static page *take_page(heap *self)
{
    page *p = self->free_pages;
    if (p) {
        self->free_pages = p->next_free;
    } else {
        p = aligned_alloc(64, sizeof *p);
        if (!p) return NULL;
    }
    p->holders = 1, p->next_free = NULL;
    self->held_pages++;
    return p;
}

static void let_page_go(heap *self, page *p)
{
    if (--p->holders) return;
    p->next_free = self->free_pages;
    self->free_pages = p;
    self->held_pages--;
}

/* The page as it is now: that of the latest image where it is the same, else a copy. */
static page *page_now(heap *self, size_t i)
{
    const unsigned char *now = self->base + i * PAGE;
    page *before = self->latest && i < self->latest->count ? self->latest->pages[i] : NULL;
    if (before && memcmp(before->bytes, now, PAGE) == 0) {
        before->holders++;
        return before;
    }
    page *fresh = take_page(self);
    if (fresh) memcpy(fresh->bytes, now, PAGE);
    return fresh;
}

heap_image *heap_keep(heap *self)
{
    const size_t count = round_up(heap_used(self), PAGE) / PAGE;
    heap_image *image = malloc(sizeof *image + count * sizeof image->pages[0]);
    if (!image) return NULL;
    for (image->count = 0; image->count < count; image->count++)
        if (!(image->pages[image->count] = page_now(self, image->count))) break;
    self->listed_pages += image->count;
    if (image->count < count) {
        heap_image_free(self, image);
        return NULL;
    }
    self->latest = image;
    return image;
}

void heap_put_back(heap *self, const heap_image *image)
{
    for (size_t i = 0; i < image->count; i++) {
        unsigned char *now = self->base + i * PAGE;
        if (memcmp(now, image->pages[i]->bytes, PAGE) != 0) memcpy(now, image->pages[i]->bytes, PAGE);
    }
    self->latest = image;
}

void heap_liken(heap *self, const heap_image *image) { self->latest = image; }

void heap_image_free(heap *self, heap_image *image)
{
    if (!image) return;
    for (size_t i = 0; i < image->count; i++) let_page_go(self, image->pages[i]);
    self->listed_pages -= image->count;
    if (self->latest == image) self->latest = NULL;
    free(image);
}

void heap_close(heap *self)
{
    if (!self) return;
    for (page *p = self->free_pages; p;) {
        page *next = p->next_free;
        free(p);
        p = next;
    }
    munmap(self->base, self->size);
    pthread_mutex_destroy(&self->lock);
    free(self);
}
