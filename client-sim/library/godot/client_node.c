/* The methods of ZonedClient: the calls of zoned_client.h in values that scripts know. */
#include "client_node.h"

#include <stdlib.h>
#include <string.h>

void* copy_of(const void* data, size_t size) {
    char* const copy = malloc(size + 1);
    if (copy != NULL) {
        memcpy(copy, data, size);
        copy[size] = 0;
    }
    return copy;
}

static void give_text(value* out, const char* text) {
    out->data = text;
    out->size = strlen(text);
}

static void give_vector(value* out, const double from[3]) {
    int i;
    for (i = 0; i < 3; ++i) {
        out->part[i] = (float)from[i];
    }
}

/* ------------------------------------------------------------------ methods */

static void connect_to_server(node* self, const value* in, value* out) {
    zoned_client_settings settings = {.size = sizeof settings};
    zoned_client_destroy(self->client);
    self->count = 0;
    settings.name = in[2].data;
    settings.team = self->team;
    settings.ticket = self->ticket;
    settings.ticket_size = self->ticket_size;
    settings.pin = self->pin;
    settings.trust = self->pin != NULL ? ZONED_CLIENT_TRUST_PIN : ZONED_CLIENT_TRUST_DEFAULT;
    self->error[0] = 0;
    self->client =
        zoned_client_create(ZONED_CLIENT_ABI, &settings, self->error, sizeof self->error);
    if (self->client == NULL) {
        return;
    }
    if (in[1].integer < 1 || in[1].integer > 65535) {
        strcpy(self->error, "the port is not one of 1 to 65535");
        return;
    }
    out->truth = zoned_client_connect(self->client, in[0].data, (uint16_t)in[1].integer) == 0;
}

static void set_team(node* self, const value* in, value* out) {
    (void)out;
    free(self->team);
    self->team = copy_of(in[0].data, in[0].size);
}

static void set_ticket(node* self, const value* in, value* out) {
    (void)out;
    free(self->ticket);
    self->ticket = copy_of(in[0].data, in[0].size);
    self->ticket_size = self->ticket != NULL ? in[0].size : 0;
}

static void set_pin(node* self, const value* in, value* out) {
    (void)out;
    free(self->pin);
    self->pin = in[0].size > 0 ? copy_of(in[0].data, in[0].size) : NULL;
}

static void read_entities(node* self) {
    size_t count = zoned_client_entities(self->client, NULL, 0);
    if (count > self->capacity) {
        zoned_client_entity* const more = realloc(self->entities, 2 * count * sizeof *more);
        if (more != NULL) {
            self->entities = more;
            self->capacity = 2 * count;
        }
    }
    if (self->capacity > 0) {
        self->entities[0].size = sizeof self->entities[0];
        count = zoned_client_entities(self->client, self->entities, self->capacity);
    }
    self->count = count < self->capacity ? count : self->capacity;
}

static void poll_client(node* self, const value* in, value* out) {
    out->integer = ZONED_CLIENT_IDLE;
    if (self->client != NULL) {
        out->integer = zoned_client_poll(self->client, in[0].number);
        read_entities(self);
    }
}

static void quit(node* self, const value* in, value* out) {
    (void)in;
    (void)out;
    if (self->client != NULL) {
        zoned_client_quit(self->client);
    }
}

static void trouble(node* self, const value* in, value* out) {
    (void)in;
    give_text(out,
              self->error[0] != 0 || self->client == NULL ? self->error
                                                          : zoned_client_trouble(self->client));
}

static void set_input(node* self, const value* in, value* out) {
    zoned_client_input input = {.size = sizeof input};
    input.move_x = (float)in[0].number;
    input.move_z = (float)in[1].number;
    input.yaw = (float)in[2].number;
    input.pitch = (float)in[3].number;
    input.buttons = (uint32_t)in[4].integer;
    out->truth = self->client != NULL && zoned_client_set_input(self->client, &input) == 0;
}

static void send_command(node* self, const value* in, value* out) {
    out->truth =
        self->client != NULL && in[0].integer >= 0 &&
        zoned_client_command(self->client, (uint32_t)in[0].integer, in[1].data, in[1].size) == 0;
}

static int own_avatar(const node* self, zoned_client_avatar* own) {
    memset(own, 0, sizeof *own);
    own->size = sizeof *own;
    return self->client != NULL && zoned_client_own(self->client, own) == 1;
}

static void avatar_id(node* self, const value* in, value* out) {
    zoned_client_avatar own;
    (void)in;
    out->integer = own_avatar(self, &own) ? own.id : 0;
}

static void avatar_position(node* self, const value* in, value* out) {
    zoned_client_avatar own;
    (void)in;
    own_avatar(self, &own);
    give_vector(out, own.position);
}

static void avatar_eye(node* self, const value* in, value* out) {
    zoned_client_avatar own;
    (void)in;
    own_avatar(self, &own);
    give_vector(out, own.eye);
}

static void avatar_yaw(node* self, const value* in, value* out) {
    zoned_client_avatar own;
    (void)in;
    own_avatar(self, &own);
    out->number = own.yaw;
}

static void entity_count(node* self, const value* in, value* out) {
    (void)in;
    out->integer = (int64_t)self->count;
}

/* An index beyond the last has no entity: id 0 at the origin. */
static const zoned_client_entity* entity_at(const node* self, const value* in) {
    static const zoned_client_entity kNone = {.orientation = {0, 0, 0, 1}};
    return in[0].integer >= 0 && (uint64_t)in[0].integer < self->count
               ? &self->entities[in[0].integer]
               : &kNone;
}

static void entity_id(node* self, const value* in, value* out) {
    out->integer = entity_at(self, in)->id;
}

static void entity_type(node* self, const value* in, value* out) {
    const zoned_client_entity* const entity = entity_at(self, in);
    self->type = (zoned_client_type_info){.size = sizeof self->type};
    if (entity->id != 0) {
        zoned_client_type(self->client, entity->type, &self->type);
    }
    give_text(out, self->type.name);
}

static void entity_position(node* self, const value* in, value* out) {
    give_vector(out, entity_at(self, in)->position);
}

static void entity_orientation(node* self, const value* in, value* out) {
    memcpy(out->part, entity_at(self, in)->orientation, sizeof out->part);
}

static void entity_velocity(node* self, const value* in, value* out) {
    memcpy(out->part, entity_at(self, in)->velocity, 3 * sizeof(float));
}

static void read_field(node* self, const value* in) {
    self->field = (zoned_client_field_value){.size = sizeof self->field};
    if (self->client != NULL && in[0].integer > 0 && in[0].integer <= UINT32_MAX) {
        zoned_client_field_named(self->client, (uint32_t)in[0].integer, in[1].data, &self->field);
    }
}

static void field_number(node* self, const value* in, value* out) {
    read_field(self, in);
    out->number = self->field.number;
}

static void field_text(node* self, const value* in, value* out) {
    read_field(self, in);
    give_text(out, self->field.text);
}

static void next_event(node* self, const value* in, value* out) {
    int got = 0;
    (void)in;
    self->event = (zoned_client_event){.size = sizeof self->event};
    if (self->client != NULL) {
        got = zoned_client_next_event(
            self->client, &self->event, self->payload, self->payload_capacity);
    }
    if (got == ZONED_CLIENT_TOO_SMALL) {
        void* const more = realloc(self->payload, self->event.payload_size);
        if (more != NULL) {
            self->payload = more;
            self->payload_capacity = self->event.payload_size;
            got = zoned_client_next_event(
                self->client, &self->event, self->payload, self->payload_capacity);
        }
    }
    out->truth = got == 1;
}

static void event_kind(node* self, const value* in, value* out) {
    (void)in;
    out->integer = self->event.kind;
}

static void event_tick(node* self, const value* in, value* out) {
    (void)in;
    out->integer = self->event.tick;
}

static void event_payload(node* self, const value* in, value* out) {
    (void)in;
    out->data = self->payload;
    out->size = self->event.payload_size < self->payload_capacity ? self->event.payload_size
                                                                  : self->payload_capacity;
}

static void stats(const node* self, zoned_client_stats_info* out) {
    memset(out, 0, sizeof *out);
    out->size = sizeof *out;
    if (self->client != NULL) {
        zoned_client_stats(self->client, out);
    }
}

static void rtt_ms(node* self, const value* in, value* out) {
    zoned_client_stats_info info;
    (void)in;
    stats(self, &info);
    out->number = info.rtt_ms;
}

static void correction_m(node* self, const value* in, value* out) {
    zoned_client_stats_info info;
    (void)in;
    stats(self, &info);
    out->number = info.correction_last_m;
}

static void server_time(node* self, const value* in, value* out) {
    (void)in;
    out->number = self->client != NULL ? zoned_client_server_time(self->client) : 0.0;
}

/* ------------------------------------------------------------------ what Godot is told of them */

const method kMethods[] = {
    {"connect_to_server",
     connect_to_server,
     BOOL,
     3,
     {STRING, INT, STRING},
     {"host", "port", "name"}},
    {"set_team", set_team, VOID, 1, {STRING}, {"team"}},
    {"set_ticket", set_ticket, VOID, 1, {BYTES}, {"ticket"}},
    {"set_pin", set_pin, VOID, 1, {STRING}, {"sha256_hex"}},
    {"poll", poll_client, INT, 1, {FLOAT}, {"now_s"}},
    {"quit", quit, VOID, 0, {0}, {0}},
    {"trouble", trouble, STRING, 0, {0}, {0}},
    {"set_input",
     set_input,
     BOOL,
     5,
     {FLOAT, FLOAT, FLOAT, FLOAT, INT},
     {"move_x", "move_z", "yaw", "pitch", "buttons"}},
    {"send_command", send_command, BOOL, 2, {INT, BYTES}, {"kind", "payload"}},
    {"avatar_id", avatar_id, INT, 0, {0}, {0}},
    {"avatar_position", avatar_position, VECTOR3, 0, {0}, {0}},
    {"avatar_eye", avatar_eye, VECTOR3, 0, {0}, {0}},
    {"avatar_yaw", avatar_yaw, FLOAT, 0, {0}, {0}},
    {"entity_count", entity_count, INT, 0, {0}, {0}},
    {"entity_id", entity_id, INT, 1, {INT}, {"index"}},
    {"entity_type", entity_type, STRING, 1, {INT}, {"index"}},
    {"entity_position", entity_position, VECTOR3, 1, {INT}, {"index"}},
    {"entity_orientation", entity_orientation, QUATERNION, 1, {INT}, {"index"}},
    {"entity_velocity", entity_velocity, VECTOR3, 1, {INT}, {"index"}},
    {"field_number", field_number, FLOAT, 2, {INT, STRING}, {"entity", "field"}},
    {"field_text", field_text, STRING, 2, {INT, STRING}, {"entity", "field"}},
    {"next_event", next_event, BOOL, 0, {0}, {0}},
    {"event_kind", event_kind, INT, 0, {0}, {0}},
    {"event_tick", event_tick, INT, 0, {0}, {0}},
    {"event_payload", event_payload, BYTES, 0, {0}, {0}},
    {"rtt_ms", rtt_ms, FLOAT, 0, {0}, {0}},
    {"correction_m", correction_m, FLOAT, 0, {0}, {0}},
    {"server_time", server_time, FLOAT, 0, {0}, {0}},
};

const size_t kMethodCount = sizeof kMethods / sizeof kMethods[0];

void delete_node(node* self) {
    zoned_client_destroy(self->client);
    free(self->team);
    free(self->ticket);
    free(self->pin);
    free(self->entities);
    free(self->payload);
    free(self);
}
