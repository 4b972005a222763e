// client_node: one client of a script, and the methods that scripts call.
#pragma once

#include <gdextension_interface.h>
#include <zoned_client.h>

#define MOST_ARGUMENTS 5

/* Types of arguments and results. */
#define VOID GDEXTENSION_VARIANT_TYPE_NIL
#define BOOL GDEXTENSION_VARIANT_TYPE_BOOL
#define INT GDEXTENSION_VARIANT_TYPE_INT
#define FLOAT GDEXTENSION_VARIANT_TYPE_FLOAT
#define STRING GDEXTENSION_VARIANT_TYPE_STRING
#define VECTOR3 GDEXTENSION_VARIANT_TYPE_VECTOR3
#define QUATERNION GDEXTENSION_VARIANT_TYPE_QUATERNION
#define BYTES GDEXTENSION_VARIANT_TYPE_PACKED_BYTE_ARRAY

/* One argument or result. Texts end in 0, which `size` leaves out. */
typedef struct {
    int64_t integer;
    double number;
    GDExtensionBool truth;
    float part[4];
    const void* data;
    size_t size;
} value;

/* One client of a script. */
typedef struct {
    zoned_client* client; /* null before the first connect_to_server() */
    char* team;
    void* ticket;
    size_t ticket_size;
    char* pin;
    char error[256]; /* why there is no client */
    zoned_client_entity* entities;
    size_t count;
    size_t capacity;
    zoned_client_event event;
    void* payload;
    size_t payload_capacity;
    zoned_client_type_info type;    /* whose name was returned last */
    zoned_client_field_value field; /* likewise */
} node;

typedef struct {
    const char* name;
    void (*run)(node* self, const value* in, value* out);
    int result;
    int count;
    int type[MOST_ARGUMENTS];
    const char* argument[MOST_ARGUMENTS];
} method;

extern const method kMethods[];
extern const size_t kMethodCount;

/* `size` bytes and a 0 after them; null without memory. */
void* copy_of(const void* data, size_t size);
void delete_node(node* self);
