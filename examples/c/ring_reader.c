/* Reads the finished frames that a program publishes: prints the number and the pictures of each frame, and writes the
 * first picture of the last one as a PPM file.
 *
 * cupola run --publish -- program &  ring_reader /dev/shm/cupola-$(id -u) last.ppm
 *
 * The layout of the file is defined in cupola_ring.h. Builds as C99 and as C++. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "cupola_ring.h"

#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <linux/futex.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

typedef struct {
    int descriptor;
    uint64_t *words;
    uint64_t count;                         /* words of the file */
    uint64_t slots, slot_words, first_slot; /* from the header, checked */
    int entry;                              /* this reader's entry */
} ring;

typedef struct {
    uint64_t number, index, width, height;
    char name[CUPOLA_RING_NAME_BYTES + 1];
    uint64_t room; /* bytes of `pixels` */
    unsigned char *pixels;
} frame;

static uint64_t load(const uint64_t *word)
{
    return __atomic_load_n(word, __ATOMIC_ACQUIRE);
}

static void store(uint64_t *word, uint64_t value)
{
    __atomic_store_n(word, value, __ATOMIC_RELEASE);
}

static void *low_half(uint64_t *word)
{
    const uint16_t one = 1;
    const int is_little = *(const unsigned char *)&one;
    return (char *)word + (is_little ? 0 : 4);
}

/* Waits while the low half of a word is `value`, at most for a tenth of a second. */
static void wait_for(uint64_t *word, uint64_t value)
{
    const struct timespec limit = {0, 100000000};
    syscall(SYS_futex, low_half(word), FUTEX_WAIT, (uint32_t)value, &limit);
}

static uint64_t *reader_word(const ring *r, int entry, int word)
{
    return r->words + CUPOLA_RING_FIRST_READER + entry * CUPOLA_RING_READER_WORDS + word;
}

/* Wakes the writer, which may wait for readers. */
static void tell_taken(const ring *r)
{
    __atomic_fetch_add(r->words + CUPOLA_RING_HEADER_TAKEN, 1, __ATOMIC_RELEASE);
    syscall(SYS_futex, low_half(r->words + CUPOLA_RING_HEADER_TAKEN), FUTEX_WAKE, INT_MAX);
}

/* Runs a lock command on the first byte of a word. */
static int lock_of(const ring *r, int command, const uint64_t *word, struct flock *range)
{
    memset(range, 0, sizeof *range);
    range->l_type = F_WRLCK;
    range->l_whence = SEEK_SET;
    range->l_start = (off_t)((word - r->words) * 8);
    range->l_len = 1;
    return fcntl(r->descriptor, command, range) != -1;
}

static int take_lock(const ring *r, int entry)
{
    struct flock range;
    return lock_of(r, F_OFD_SETLK, reader_word(r, entry, 0), &range);
}

static int writer_lives(const ring *r)
{
    struct flock range;
    return lock_of(r, F_OFD_GETLK, r->words + CUPOLA_RING_HEADER_WRITER_LOCK, &range) && range.l_type != F_UNLCK;
}

/* Reads the layout of the file; 0 if it is not a file of published frames. */
static int check(ring *r)
{
    const uint64_t least = CUPOLA_RING_FIRST_READER + CUPOLA_RING_READERS * CUPOLA_RING_READER_WORDS;
    if (r->count < least || memcmp(r->words, CUPOLA_RING_MAGIC, 8) != 0 ||
        load(r->words + CUPOLA_RING_HEADER_VERSION) != CUPOLA_RING_VERSION)
        return 0;
    r->slots = load(r->words + CUPOLA_RING_HEADER_SLOTS);
    r->slot_words = load(r->words + CUPOLA_RING_HEADER_SLOT_WORDS);
    r->first_slot = load(r->words + CUPOLA_RING_HEADER_FIRST_SLOT);
    return r->slots > 0 && r->first_slot >= least && r->first_slot <= r->count &&
           r->slot_words >= CUPOLA_RING_SLOT_TABLE + CUPOLA_RING_PICTURES * CUPOLA_RING_PICTURE_WORDS &&
           r->slot_words <= (r->count - r->first_slot) / r->slots;
}

static void close_ring(ring *r)
{
    if (r->words)
        munmap(r->words, (size_t)r->count * 8);
    close(r->descriptor);
    r->words = NULL;
}

/* Opens a file. `before`: this reader's entry in the earlier file of that name, or -1. */
static int open_ring(ring *r, const char *path, int before)
{
    struct stat status;
    void *memory;
    int entry;
    memset(r, 0, sizeof *r);
    r->descriptor = open(path, O_RDWR | O_CLOEXEC);
    if (r->descriptor < 0)
        return 0;
    if (fstat(r->descriptor, &status) == 0 && status.st_size >= 8) {
        memory = mmap(NULL, (size_t)status.st_size, PROT_READ | PROT_WRITE, MAP_SHARED, r->descriptor, 0);
        r->words = memory == MAP_FAILED ? NULL : (uint64_t *)memory;
        r->count = (uint64_t)status.st_size / 8;
    }
    if (!r->words || !check(r)) {
        close_ring(r);
        return 0;
    }
    if (before >= 0 && load(reader_word(r, before, 0)) == CUPOLA_RING_EXPECTED && take_lock(r, before)) {
        r->entry = before;
        store(reader_word(r, before, CUPOLA_RING_READER_STATE), CUPOLA_RING_ACTIVE);
        tell_taken(r);
        return 1;
    }
    for (entry = 0; entry < CUPOLA_RING_READERS; entry++) {
        uint64_t *state = reader_word(r, entry, CUPOLA_RING_READER_STATE);
        uint64_t *cursor = reader_word(r, entry, CUPOLA_RING_READER_CURSOR);
        if (load(state) == CUPOLA_RING_EXPECTED || !take_lock(r, entry))
            continue;
        r->entry = entry;
        store(state, CUPOLA_RING_FREE);
        store(reader_word(r, entry, CUPOLA_RING_READER_LOST), 0);
        store(cursor, load(r->words + CUPOLA_RING_HEADER_PUBLISHED));
        store(state, CUPOLA_RING_ACTIVE);
        __atomic_thread_fence(__ATOMIC_SEQ_CST);
        for (;;) {
            /* The writer may move the cursor at the same time, but only forward. */
            uint64_t known = load(cursor), published = load(r->words + CUPOLA_RING_HEADER_PUBLISHED);
            if (known >= published ||
                __atomic_compare_exchange_n(cursor, &known, published, 0, __ATOMIC_ACQ_REL, __ATOMIC_RELAXED))
                break;
        }
        tell_taken(r);
        return 1;
    }
    close_ring(r);
    return 0;
}

/*
 * Copies the first picture of frame `number`. 1: done; 0: the writer has overwritten it; -1: the file is damaged, or
 * has other pictures.
 */
static int copy(const ring *r, uint64_t number, frame *f)
{
    const uint64_t *slot = r->words + r->first_slot + number % r->slots * r->slot_words;
    const uint64_t *entry = slot + CUPOLA_RING_SLOT_TABLE;
    const int was_whole = load(slot + CUPOLA_RING_SLOT_SEQUENCE) == 2 * number + 2;
    int is_good = was_whole;
    if (was_whole) {
        const uint64_t pixels = entry[CUPOLA_RING_PICTURE_PIXELS];
        f->number = number;
        f->index = slot[CUPOLA_RING_SLOT_INDEX];
        f->width = entry[CUPOLA_RING_PICTURE_WIDTH];
        f->height = entry[CUPOLA_RING_PICTURE_HEIGHT];
        memcpy(f->name, entry + CUPOLA_RING_PICTURE_NAME, CUPOLA_RING_NAME_BYTES);
        is_good = slot[CUPOLA_RING_SLOT_PICTURES] >= 1 && entry[CUPOLA_RING_PICTURE_FORMAT] == CUPOLA_RING_RGBA8 &&
                  f->width - 1 < 65536 && f->height - 1 < 65536 && pixels <= r->slot_words &&
                  f->width * f->height <= (r->slot_words - pixels) * 2;
        if (is_good && f->room < f->width * f->height * 4) {
            f->room = f->width * f->height * 4;
            free(f->pixels);
            f->pixels = (unsigned char *)malloc((size_t)f->room);
            if (!f->pixels) {
                fprintf(stderr, "ring_reader: not enough memory for a picture\n");
                exit(1);
            }
        }
        if (is_good)
            memcpy(f->pixels, slot + pixels, (size_t)(f->width * f->height * 4));
    }
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
    if (!__atomic_compare_exchange_n(reader_word(r, r->entry, CUPOLA_RING_READER_CURSOR), &number, number + 1, 0,
                                     __ATOMIC_ACQ_REL, __ATOMIC_RELAXED))
        return 0;
    tell_taken(r);
    return is_good ? 1 : -1;
}

/* Reads the next frame. 1: done; 0: the program has ended; -1: the file is damaged, or has other pictures. */
static int next_frame(ring *r, const char *path, frame *f)
{
    for (;;) {
        uint64_t *published = r->words + CUPOLA_RING_HEADER_PUBLISHED;
        const uint64_t cursor = load(reader_word(r, r->entry, CUPOLA_RING_READER_CURSOR));
        const uint64_t state = load(r->words + CUPOLA_RING_HEADER_STATE);
        const uint64_t count = load(published);
        if (cursor < count) {
            const int copied = copy(r, cursor, f);
            if (copied)
                return copied;
        } else if (state == CUPOLA_RING_REPLACED) {
            const int entry = r->entry;
            close_ring(r);
            if (!open_ring(r, path, entry))
                return 0;
        } else if (state != CUPOLA_RING_OPEN) {
            return 0;
        } else {
            wait_for(published, count);
            if (load(published) == count && !writer_lives(r) && load(published) == count)
                return 0;
        }
    }
}

static int write_ppm(const char *path, const frame *f)
{
    uint64_t pixel;
    FILE *file = fopen(path, "wb");
    if (!file)
        return 0;
    fprintf(file, "P6\n%" PRIu64 " %" PRIu64 "\n255\n", f->width, f->height);
    for (pixel = 0; pixel < f->width * f->height; pixel++)
        fwrite(f->pixels + pixel * 4, 1, 3, file);
    return fclose(file) == 0;
}

int main(int argc, char **argv)
{
    const struct timespec moment = {0, 5000000};
    int attempt, result;
    ring r;
    frame f;
    if (argc != 3) {
        fprintf(stderr, "usage: ring_reader FILE LAST.ppm\n");
        return 2;
    }
    memset(&f, 0, sizeof f);
    /* The program may start up to a minute later. */
    for (attempt = 0; !open_ring(&r, argv[1], -1); attempt++) {
        if (attempt == 12000) {
            fprintf(stderr, "ring_reader: %s has no published frames\n", argv[1]);
            return 1;
        }
        nanosleep(&moment, NULL);
    }
    while ((result = next_frame(&r, argv[1], &f)) == 1)
        printf("frame %" PRIu64 " %s %" PRIu64 "x%" PRIu64 "\n", f.index, f.name, f.width, f.height);
    if (result < 0)
        fprintf(stderr, "ring_reader: %s is damaged, or its pictures do not have 8 bits for each colour\n", argv[1]);
    if (r.words) {
        printf("lost %" PRIu64 "\n", load(reader_word(&r, r.entry, CUPOLA_RING_READER_LOST)));
        store(reader_word(&r, r.entry, CUPOLA_RING_READER_STATE), CUPOLA_RING_FREE);
        tell_taken(&r);
        close_ring(&r);
    }
    if (f.pixels && !write_ppm(argv[2], &f)) {
        fprintf(stderr, "ring_reader: %s cannot be written\n", argv[2]);
        result = -1;
    }
    free(f.pixels);
    return result < 0;
}
