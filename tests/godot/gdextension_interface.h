// The part of Godot's interface for extensions that client-sim/library/godot uses, declared anew
// for the test: names, order and types are those of Godot 4.2 and newer. A game compiles against
// the header that its own Godot writes (godot --dump-gdextension-interface).
#pragma once

#include <stddef.h>
#include <stdint.h>

typedef enum {
    GDEXTENSION_VARIANT_TYPE_NIL = 0,
    GDEXTENSION_VARIANT_TYPE_BOOL = 1,
    GDEXTENSION_VARIANT_TYPE_INT = 2,
    GDEXTENSION_VARIANT_TYPE_FLOAT = 3,
    GDEXTENSION_VARIANT_TYPE_STRING = 4,
    GDEXTENSION_VARIANT_TYPE_VECTOR3 = 9,
    GDEXTENSION_VARIANT_TYPE_QUATERNION = 15,
    GDEXTENSION_VARIANT_TYPE_STRING_NAME = 21,
    GDEXTENSION_VARIANT_TYPE_PACKED_BYTE_ARRAY = 29
} GDExtensionVariantType;

typedef int64_t GDExtensionInt;
typedef uint8_t GDExtensionBool;
typedef void* GDExtensionVariantPtr;
typedef const void* GDExtensionConstVariantPtr;
typedef void* GDExtensionStringNamePtr;
typedef const void* GDExtensionConstStringNamePtr;
typedef void* GDExtensionStringPtr;
typedef const void* GDExtensionConstStringPtr;
typedef void* GDExtensionTypePtr;
typedef const void* GDExtensionConstTypePtr;
typedef void* GDExtensionObjectPtr;
typedef void* GDExtensionClassInstancePtr;
typedef void* GDExtensionClassLibraryPtr;
typedef void (*GDExtensionInterfaceFunctionPtr)();
typedef GDExtensionInterfaceFunctionPtr (*GDExtensionInterfaceGetProcAddress)(const char*);

/* ------------------------------------------------------------------ values */

typedef void (*GDExtensionVariantFromTypeConstructorFunc)(GDExtensionVariantPtr,
                                                          GDExtensionTypePtr);
typedef void (*GDExtensionTypeFromVariantConstructorFunc)(GDExtensionTypePtr,
                                                          GDExtensionVariantPtr);
typedef void (*GDExtensionPtrConstructor)(GDExtensionTypePtr, const GDExtensionConstTypePtr*);
typedef void (*GDExtensionPtrDestructor)(GDExtensionTypePtr);
typedef void (*GDExtensionPtrBuiltInMethod)(GDExtensionTypePtr,
                                            const GDExtensionConstTypePtr*,
                                            GDExtensionTypePtr,
                                            int);

typedef void (*GDExtensionInterfacePrintError)(const char*,
                                               const char*,
                                               const char*,
                                               int32_t,
                                               GDExtensionBool);
typedef GDExtensionVariantType (*GDExtensionInterfaceVariantGetType)(GDExtensionConstVariantPtr);
typedef GDExtensionVariantFromTypeConstructorFunc (
    *GDExtensionInterfaceGetVariantFromTypeConstructor)(GDExtensionVariantType);
typedef GDExtensionTypeFromVariantConstructorFunc (
    *GDExtensionInterfaceGetVariantToTypeConstructor)(GDExtensionVariantType);
typedef GDExtensionPtrConstructor (
    *GDExtensionInterfaceVariantGetPtrConstructor)(GDExtensionVariantType, int32_t);
typedef GDExtensionPtrDestructor (*GDExtensionInterfaceVariantGetPtrDestructor)(
    GDExtensionVariantType);
typedef GDExtensionPtrBuiltInMethod (*GDExtensionInterfaceVariantGetPtrBuiltinMethod)(
    GDExtensionVariantType,
    GDExtensionConstStringNamePtr,
    GDExtensionInt);
typedef void (*GDExtensionInterfaceStringNewWithUtf8CharsAndLen)(GDExtensionStringPtr,
                                                                 const char*,
                                                                 GDExtensionInt);
typedef GDExtensionInt (*GDExtensionInterfaceStringToUtf8Chars)(GDExtensionConstStringPtr,
                                                                char*,
                                                                GDExtensionInt);
typedef void (*GDExtensionInterfaceStringNameNewWithLatin1Chars)(GDExtensionStringNamePtr,
                                                                 const char*,
                                                                 GDExtensionBool);
typedef uint8_t* (*GDExtensionInterfacePackedByteArrayOperatorIndex)(GDExtensionTypePtr,
                                                                     GDExtensionInt);
typedef const uint8_t* (*GDExtensionInterfacePackedByteArrayOperatorIndexConst)(
    GDExtensionConstTypePtr,
    GDExtensionInt);

/* ------------------------------------------------------------------ classes */

typedef GDExtensionObjectPtr (*GDExtensionClassCreateInstance)(void*);
typedef void (*GDExtensionClassFreeInstance)(void*, GDExtensionClassInstancePtr);
typedef void (*GDExtensionUnusedHook)(); /* stands for hooks that no extension of ours sets */

typedef struct {
    GDExtensionBool is_virtual;
    GDExtensionBool is_abstract;
    GDExtensionBool is_exposed;
    GDExtensionUnusedHook set_func;
    GDExtensionUnusedHook get_func;
    GDExtensionUnusedHook get_property_list_func;
    GDExtensionUnusedHook free_property_list_func;
    GDExtensionUnusedHook property_can_revert_func;
    GDExtensionUnusedHook property_get_revert_func;
    GDExtensionUnusedHook validate_property_func;
    GDExtensionUnusedHook notification_func;
    GDExtensionUnusedHook to_string_func;
    GDExtensionUnusedHook reference_func;
    GDExtensionUnusedHook unreference_func;
    GDExtensionClassCreateInstance create_instance_func;
    GDExtensionClassFreeInstance free_instance_func;
    GDExtensionUnusedHook recreate_instance_func;
    GDExtensionUnusedHook get_virtual_func;
    GDExtensionUnusedHook get_virtual_call_data_func;
    GDExtensionUnusedHook call_virtual_with_data_func;
    GDExtensionUnusedHook get_rid_func;
    void* class_userdata;
} GDExtensionClassCreationInfo2;

typedef enum {
    GDEXTENSION_CALL_OK,
    GDEXTENSION_CALL_ERROR_INVALID_METHOD,
    GDEXTENSION_CALL_ERROR_INVALID_ARGUMENT,
    GDEXTENSION_CALL_ERROR_TOO_MANY_ARGUMENTS,
    GDEXTENSION_CALL_ERROR_TOO_FEW_ARGUMENTS
} GDExtensionCallErrorType;

typedef struct {
    GDExtensionCallErrorType error;
    int32_t argument;
    int32_t expected;
} GDExtensionCallError;

typedef struct {
    GDExtensionVariantType type;
    GDExtensionStringNamePtr name;
    GDExtensionStringNamePtr class_name;
    uint32_t hint;
    GDExtensionStringPtr hint_string;
    uint32_t usage;
} GDExtensionPropertyInfo;

enum {
    GDEXTENSION_METHOD_FLAGS_DEFAULT = 1
};

typedef enum {
    GDEXTENSION_METHOD_ARGUMENT_METADATA_NONE
} GDExtensionClassMethodArgumentMetadata;

typedef void (*GDExtensionClassMethodCall)(void*,
                                           GDExtensionClassInstancePtr,
                                           const GDExtensionConstVariantPtr*,
                                           GDExtensionInt,
                                           GDExtensionVariantPtr,
                                           GDExtensionCallError*);
typedef void (*GDExtensionClassMethodPtrCall)(void*,
                                              GDExtensionClassInstancePtr,
                                              const GDExtensionConstTypePtr*,
                                              GDExtensionTypePtr);

typedef struct {
    GDExtensionStringNamePtr name;
    void* method_userdata;
    GDExtensionClassMethodCall call_func;
    GDExtensionClassMethodPtrCall ptrcall_func;
    uint32_t method_flags;
    GDExtensionBool has_return_value;
    GDExtensionPropertyInfo* return_value_info;
    GDExtensionClassMethodArgumentMetadata return_value_metadata;
    uint32_t argument_count;
    GDExtensionPropertyInfo* arguments_info;
    GDExtensionClassMethodArgumentMetadata* arguments_metadata;
    uint32_t default_argument_count;
    GDExtensionVariantPtr* default_arguments;
} GDExtensionClassMethodInfo;

typedef GDExtensionObjectPtr (*GDExtensionInterfaceClassdbConstructObject)(
    GDExtensionConstStringNamePtr);
typedef void (*GDExtensionInterfaceObjectSetInstance)(GDExtensionObjectPtr,
                                                      GDExtensionConstStringNamePtr,
                                                      GDExtensionClassInstancePtr);
typedef void (*GDExtensionInterfaceClassdbRegisterExtensionClass2)(
    GDExtensionClassLibraryPtr,
    GDExtensionConstStringNamePtr,
    GDExtensionConstStringNamePtr,
    const GDExtensionClassCreationInfo2*);
typedef void (*GDExtensionInterfaceClassdbRegisterExtensionClassMethod)(
    GDExtensionClassLibraryPtr,
    GDExtensionConstStringNamePtr,
    const GDExtensionClassMethodInfo*);
typedef void (*GDExtensionInterfaceClassdbUnregisterExtensionClass)(GDExtensionClassLibraryPtr,
                                                                    GDExtensionConstStringNamePtr);

/* ------------------------------------------------------------------ start and end */

typedef enum {
    GDEXTENSION_INITIALIZATION_CORE,
    GDEXTENSION_INITIALIZATION_SERVERS,
    GDEXTENSION_INITIALIZATION_SCENE,
    GDEXTENSION_INITIALIZATION_EDITOR
} GDExtensionInitializationLevel;

typedef struct {
    GDExtensionInitializationLevel minimum_initialization_level;
    void* userdata;
    void (*initialize)(void*, GDExtensionInitializationLevel);
    void (*deinitialize)(void*, GDExtensionInitializationLevel);
} GDExtensionInitialization;
