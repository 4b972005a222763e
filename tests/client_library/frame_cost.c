/* Time and allocations of a game's frame with many entities in sight: frame_cost PORT ENTITIES */
#define _GNU_SOURCE
#include <zoned_client.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define MOST_ENTITIES 1024
#define FRAMES 600
/* Two ticks of the server: every second frame brings a packet. */
#define BLOCK 4
/* The budget of a frame is 0.1 ms of a core at 3 GHz. Each of these multiplications waits for the one before, 3 cycles
   on every 64-bit PC since 2008: so many are a tenth of the budget, whatever else the machine does. */
#define CHAIN 10000
#define CHAINS_IN_BUDGET 10

/* The C library's own allocator, behind one that counts: everything in the process comes by here. */
extern void* __libc_malloc(size_t size);
extern void* __libc_calloc(size_t count, size_t size);
extern void* __libc_realloc(void* at, size_t size);

static unsigned long allocations = 0;

void* malloc(size_t size) {
    ++allocations;
    return __libc_malloc(size);
}

void* calloc(size_t count, size_t size) {
    ++allocations;
    return __libc_calloc(count, size);
}

void* realloc(void* at, size_t size) {
    ++allocations;
    return __libc_realloc(at, size);
}

static double now_s(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double chain_ms(void) {
    const double begin = now_s(CLOCK_THREAD_CPUTIME_ID);
    unsigned long product = 3;
    int i;
    for (i = 0; i < CHAIN; ++i) {
        product *= 0x9E3779B97F4A7C15UL;
        __asm__ volatile("" : "+r"(product));
    }
    return 1e3 * (now_s(CLOCK_THREAD_CPUTIME_ID) - begin);
}

static void wait_a_frame(void) {
    const struct timespec sixtieth = {0, 16666667};
    nanosleep(&sixtieth, NULL);
}

static int compare(const void* a, const void* b) {
    return *(const double*)a < *(const double*)b ? -1 : 1;
}

int main(int argc, char** argv) {
    static zoned_client_entity entities[MOST_ENTITIES];
    static double cpu_ms[FRAMES / BLOCK]; /* a frame's, in the mean of a block */
    static double budget_ms[FRAMES / BLOCK];
    zoned_client_settings settings = {.size = sizeof settings, .name = "meter"};
    zoned_client_avatar own = {.size = sizeof own};
    zoned_client* client;
    unsigned long in_entities = 0;
    unsigned long in_poll = 0;
    double sum_ms = 0.0;
    size_t wanted;
    size_t seen = 0;
    int frame;
    if (argc != 3) {
        return 2;
    }
    wanted = (size_t)atoi(argv[2]);
    client = zoned_client_create(ZONED_CLIENT_ABI, &settings, NULL, 0);
    entities[0].size = sizeof entities[0];
    zoned_client_connect(client, "127.0.0.1", (uint16_t)atoi(argv[1]));
    for (frame = 0; frame < 1200 && seen < wanted; ++frame) {
        if (zoned_client_poll(client, now_s(CLOCK_MONOTONIC)) == ZONED_CLIENT_CLOSED) {
            fprintf(stderr, "%s\n", zoned_client_trouble(client));
            return 1;
        }
        seen = zoned_client_entities(client, entities, MOST_ENTITIES);
        wait_a_frame();
    }
    for (frame = 0; frame < FRAMES; ++frame) {
        const double begin = now_s(CLOCK_THREAD_CPUTIME_ID);
        unsigned long before = allocations;
        zoned_client_poll(client, now_s(CLOCK_MONOTONIC));
        in_poll += frame >= FRAMES / 2 ? allocations - before : 0; /* its memory has grown by then */
        before = allocations;
        seen = zoned_client_entities(client, entities, MOST_ENTITIES);
        in_entities += allocations - before;
        zoned_client_own(client, &own);
        const double frame_ms = 1e3 * (now_s(CLOCK_THREAD_CPUTIME_ID) - begin);
        cpu_ms[frame / BLOCK] += frame_ms / BLOCK;
        budget_ms[frame / BLOCK] += CHAINS_IN_BUDGET * chain_ms() / BLOCK;
        sum_ms += frame_ms;
        wait_a_frame();
    }
    qsort(cpu_ms, FRAMES / BLOCK, sizeof cpu_ms[0], compare);
    qsort(budget_ms, FRAMES / BLOCK, sizeof budget_ms[0], compare);
    printf("{\"entities\": %lu, \"cpu_ms_mean\": %.4f, \"cpu_ms_min\": %.4f, \"cpu_ms_p10\": %.4f, \"cpu_ms_p50\": %.4f, \"cpu_ms_p99\": %.4f, "
           "\"budget_ms_min\": %.4f, \"allocations\": %lu, \"allocations_in_entities\": %lu, \"allocations_in_poll_per_frame\": %.1f}\n",
           (unsigned long)seen,
           sum_ms / FRAMES,
           cpu_ms[0],
           cpu_ms[FRAMES / BLOCK / 10],
           cpu_ms[FRAMES / BLOCK / 2],
           cpu_ms[FRAMES / BLOCK * 99 / 100],
           budget_ms[0],
           allocations,
           in_entities,
           (double)in_poll / (FRAMES - FRAMES / 2));
    zoned_client_destroy(client);
    return 0;
}
