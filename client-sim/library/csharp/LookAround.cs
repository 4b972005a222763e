// Joins a server, walks north, and prints once a second what it sees: LookAround.exe [HOST [PORT]]
using System;
using System.Diagnostics;
using System.Globalization;
using System.Threading;
using Zoned;

public static class LookAround
{
    private static void Show(Client client)
    {
        Avatar own;
        if (client.Own(out own)) { Print("me,", own.Id, own.Position); }
        int count;
        Entity[] entities = client.Entities(out count);
        for (int i = 0; i < count; ++i)
        {
            Print(client.Type(entities[i].Type).Name, entities[i].Id, entities[i].Position);
        }
    }

    private static void Print(string name, uint id, Vector at)
    {
        Console.WriteLine(string.Format(CultureInfo.InvariantCulture, "{0} {1} at {2:F2} {3:F2} {4:F2} m", name, id, at.X, at.Y, at.Z));
    }

    public static int Main(string[] arguments)
    {
        string host = arguments.Length > 0 ? arguments[0] : "127.0.0.1";
        ushort port = arguments.Length > 1 ? ushort.Parse(arguments[1]) : (ushort)7777;
        Stopwatch clock = Stopwatch.StartNew();
        using (Client client = new Client("walker"))
        {
            client.Connect(host, port);
            client.SetInput(new Input { MoveZ = 1.0f });
            for (int frame = 1; frame <= 330; ++frame)
            {
                if (client.Poll(clock.Elapsed.TotalSeconds) == ClientState.Closed)
                {
                    Console.Error.WriteLine(client.Trouble);
                    return 1;
                }
                if (frame % 60 == 0) { Show(client); }
                Thread.Sleep(16);
            }
        }
        return 0;
    }
}
