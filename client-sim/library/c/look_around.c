/* Joins a server, walks north, and prints once a second what it sees: look_around [HOST [PORT]] */
#define _POSIX_C_SOURCE 199309L /* for clock_gettime */
#include <zoned_client.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define MOST_ENTITIES 256

static void show(zoned_client* client) {
    static zoned_client_entity entities[MOST_ENTITIES];
    zoned_client_avatar own = {.size = sizeof own};
    size_t i;
    size_t count;
    if (zoned_client_own(client, &own) == 1) {
        printf("me, %u at %.2f %.2f %.2f m\n", own.id, own.position[0], own.position[1], own.position[2]);
    }
    entities[0].size = sizeof entities[0];
    count = zoned_client_entities(client, entities, MOST_ENTITIES);
    for (i = 0; i < count && i < MOST_ENTITIES; ++i) {
        const zoned_client_entity* e = &entities[i];
        zoned_client_type_info type = {.size = sizeof type};
        zoned_client_type(client, e->type, &type);
        printf("%s %u at %.2f %.2f %.2f m\n", type.name, e->id, e->position[0], e->position[1], e->position[2]);
    }
}

int main(int argc, char** argv) {
    const char* host = argc > 1 ? argv[1] : "127.0.0.1";
    const int port = argc > 2 ? atoi(argv[2]) : 7777;
    zoned_client_settings settings = {.size = sizeof settings};
    zoned_client_input north = {.size = sizeof north};
    char error[256];
    zoned_client* client;
    int frame;

    settings.name = "walker";
    client = zoned_client_create(ZONED_CLIENT_ABI, &settings, error, sizeof error);
    if (client == NULL) {
        fprintf(stderr, "%s\n", error);
        return 1;
    }
    zoned_client_connect(client, host, (uint16_t)port);
    north.move_z = 1.0F;
    zoned_client_set_input(client, &north);
    for (frame = 1; frame <= 330; ++frame) {
        const struct timespec sixtieth = {0, 16666667};
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        if (zoned_client_poll(client, (double)now.tv_sec + 1e-9 * (double)now.tv_nsec) ==
            ZONED_CLIENT_CLOSED) {
            fprintf(stderr, "%s\n", zoned_client_trouble(client));
            zoned_client_destroy(client);
            return 1;
        }
        if (frame % 60 == 0) {
            show(client);
        }
        nanosleep(&sixtieth, NULL);
    }
    zoned_client_destroy(client);
    return 0;
}
