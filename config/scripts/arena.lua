-- Arena: chat, shots, health, respawn and inventories; the sandbox game in a small form.
-- Commands and events are those of proto/sandbox.proto, so that bots and clients know them.
--
-- What must last lies in `state` (of the zone) and `entity_state(id)` (goes with the entity to
-- other zones). Everything else is read-only once this file has run.

local CHAT, SHOOT, PICK_UP, THROW, SUBSCRIBE = 1, 2, 3, 4, 6
local JOINED, LEFT, SAID, HIT, KILLED, PICKED, INVENTORY, RESPAWNED, DENIED =
  16, 17, 18, 19, 20, 21, 22, 23, 24

local FULL_HEALTH = 100
local DAMAGE = 25
local RANGE_M = 60
local EYE_M = 0.6          -- above the centre of an avatar
local REACH_M = 3
local THROW_MPS = 12
local ROOM = 4             -- items in an inventory
local RELOAD_S, RESPAWN_S, CHAT_S = 0.4, 3, 1
local BACK = 1             -- a timer: a dead entity comes back
local PORTABLE = { ball = true, crate = true }

-- ---------------------------------------------------------------- help

local function deny(client, kind, reason)
  send(client, DENIED, encode({ kind = kind, reason = reason }, "1 int kind, 2 bytes reason"))
end

local function name_event(client, avatar, name)
  return encode({ client = client, avatar = avatar, name = name },
    "1 int client, 2 int avatar, 3 bytes name")
end

-- True, and not again before `seconds` have passed.
local function may_act(own, action, seconds)
  if own[action] and now() < own[action] then return false end
  own[action] = now() + ticks(seconds)
  return true
end

local function send_inventory(client, own)
  local items = {}
  for _, item in ipairs(own.items) do items[#items + 1] = item.id end
  send(client, INVENTORY, encode({ items = items }, "1 ints items"))
end

-- ---------------------------------------------------------------- health

local function is_target(entity)
  return client_of(entity) or type_of(entity) == "wanderer"
end

local function die(entity, by)
  announce(entity, KILLED, encode({ killer = by, killed = entity }, "1 int killer, 2 int killed"))
  if is_owned(by) then set_field(by, "kills", field(by, "kills") + 1) end
  hide(entity)
  start_timer(entity, RESPAWN_S, BACK)
end

local function hurt(entity, by, damage)
  if is_hidden(entity) then return end
  local left = math.max(field(entity, "health") - damage, 0)
  set_field(entity, "health", left)
  announce(entity, HIT, encode({ shooter = by, target = entity, damage = damage, left = left },
    "1 int shooter, 2 int target, 3 int damage, 4 int left"))
  if left == 0 then die(entity, by) end
end

function on_timer(timer, entity)   -- BACK is the only kind
  local x, y, z = freest_spawn()
  show(entity, x, y, z)
  set_field(entity, "health", FULL_HEALTH)
  announce(entity, RESPAWNED, encode({ entity = entity }, "1 int entity"))
end

-- ---------------------------------------------------------------- commands

local commands = {}

commands[CHAT] = function(client, avatar, own, payload)
  local chat = decode(payload, "1 bytes topic, 2 bytes text")
  if not chat or chat.topic ~= "world" or #chat.text == 0 or #chat.text > 200 then
    return "not your topic"
  end
  if not may_act(own, "chat", CHAT_S) then return "too fast" end
  if chat.text:sub(1, 4) == "/go " then  -- to another world of the cluster
    return not travel(client, chat.text:sub(5)) and "no way" or nil
  end
  publish("world", SAID, encode({ client = client, name = own.name, text = chat.text },
    "1 int client, 2 bytes name, 3 bytes text"))
end

commands[SUBSCRIBE] = function(client, avatar, own, payload)
  local wish = decode(payload, "1 bytes topic, 2 bool on")
  if not wish or wish.topic ~= "world" then return "not your topic" end
  if wish.on then subscribe(client, "world") else unsubscribe(client, "world") end
end

commands[SHOOT] = function(client, avatar, own, payload)
  local shot = decode(payload, "2 float dx, 3 float dy, 4 float dz")
  if not shot then return "malformed" end
  local length2 = shot.dx * shot.dx + shot.dy * shot.dy + shot.dz * shot.dz
  if not (length2 > 0.01 and length2 < 100) then return "malformed" end
  if not may_act(own, "shoot", RELOAD_S) then return "too fast" end
  local x, y, z = position(avatar)
  local distance, target = ray_cast(x, y + EYE_M, z, shot.dx, shot.dy, shot.dz, RANGE_M, avatar)
  if not target then return end
  if not is_owned(target) then   -- of the zone next door: its owner decides
    message(target, string.pack("<I4I4", avatar, DAMAGE))
  elseif is_target(target) then
    hurt(target, avatar, DAMAGE)
  else
    add_velocity(target, 2 * shot.dx, 1, 2 * shot.dz)
  end
end

commands[PICK_UP] = function(client, avatar, own, payload)
  local wish = decode(payload, "1 int entity")
  local item = wish and wish.entity
  if not item or item < 1 or item > 0xFFFFFFFF or not is_owned(item) or is_hidden(item) then
    return "no such thing"
  end
  local kind = type_of(item)
  if not PORTABLE[kind] then return "cannot be carried" end
  if distance(avatar, item) > REACH_M then return "out of reach" end
  if #own.items >= ROOM then return "inventory full" end
  table.insert(own.items, { id = item, kind = kind, look = appearance(item) })
  despawn(item)
  announce(avatar, PICKED, encode({ picker = avatar, item = item }, "1 int picker, 2 int item"))
  send_inventory(client, own)
end

commands[THROW] = function(client, avatar, own, payload)
  local wish = decode(payload, "1 int item, 2 float dx, 3 float dy, 4 float dz")
  if not wish then return "malformed" end
  local length = math.sqrt(wish.dx * wish.dx + wish.dy * wish.dy + wish.dz * wish.dz)
  if not (length > 0.1 and length < 10) then return "malformed" end
  for slot, item in ipairs(own.items) do
    if item.id == wish.item then
      local dx, dy, dz = wish.dx / length, wish.dy / length, wish.dz / length
      local x, y, z = position(avatar)
      if dy < -0.5 or ray_cast(x, y + EYE_M, z, dx, dy, dz, 2, avatar) then
        return "no room to throw"
      end
      spawn(item.kind, x + 1.5 * dx, y + EYE_M + 1.5 * dy, z + 1.5 * dz, {
        vx = THROW_MPS * dx, vy = THROW_MPS * dy, vz = THROW_MPS * dz, appearance = item.look })
      table.remove(own.items, slot)
      send_inventory(client, own)
      return
    end
  end
  return "not in your inventory"
end

-- ---------------------------------------------------------------- callbacks

function on_join(client, avatar, name)
  local own = entity_state(avatar)
  own.name, own.items = name, {}
  subscribe(client, "world")   -- first, so that a client hears of its own arrival
  publish("world", JOINED, name_event(client, avatar, name))
end

function on_leave(client, avatar)
  local own = entity_state(avatar)
  if own then
    publish("world", LEFT, name_event(client, avatar, own.name))
    despawn(avatar)
  end
end

function on_command(client, avatar, kind, payload)
  local own = entity_state(avatar)
  local command = commands[kind]
  if not own or not command or #payload > 512 then
    deny(client, kind, "unknown command")
  elseif is_hidden(avatar) and kind ~= CHAT and kind ~= SUBSCRIBE then
    deny(client, kind, "dead")
  else
    local reason = command(client, avatar, own, payload)
    if reason then deny(client, kind, reason) end
  end
end

function on_trigger(trigger, entity, entered)   -- the well is the only one
  if entered then set_field(entity, "health", FULL_HEALTH) end
end

-- The levers of the vault open and shut its door, those of the lift send it up and down; the two of
-- each go along with each other. Clients are told half a second before anything moves.
local AHEAD_S = 0.5
local VAULT_LEVERS = { "vault_outer", "vault_inner" }
local LIFT_LEVERS = { "lift_lower", "lift_upper" }

function on_use(lever, avatar, on)
  local levers = VAULT_LEVERS
  if lever == entity_named("lift_lower") or lever == entity_named("lift_upper") then
    levers = LIFT_LEVERS
    move_platform("lift", on and 1 or 0, AHEAD_S)
  else
    set_door("vault", on, AHEAD_S)
  end
  for _, name in ipairs(levers) do
    set_field(entity_named(name), "on", on)
  end
end

function on_message(target, payload)
  if is_owned(target) and is_target(target) and #payload == 8 then
    local by, damage = string.unpack("<I4I4", payload)
    hurt(target, by, damage)
  end
end
