// As much of Unity as Wall.cs needs, and a program that runs it: what CI compiles and runs without Unity.
using System;
using System.Threading;

namespace UnityEngine
{
    public class MonoBehaviour { }
}

/// A device that is pushed against the wall by a spring of a hand.
sealed class HandOnAxis : IHapticAxis
{
    double position = -0.002, velocity;
    double force;
    public double Last { get { return Volatile.Read(ref force); } }
    public bool Pushed;
    public double Deepest, Largest;
    public long Reads;

    public double ReadPosition()
    {
        Interlocked.Increment(ref Reads);
        return position;
    }

    public void WriteForce(double newForce)
    {
        Volatile.Write(ref force, newForce);
        Pushed = Pushed || newForce < 0.0;
        Largest = Math.Max(Largest, Math.Abs(newForce));
        // 0.25 kg, pushed with 2 N and held by a hand's 2 N s/m, over 1 ms.
        velocity += (2.0 - 2.0 * velocity + newForce) / 0.25 * 0.001;
        position += velocity * 0.001;
        Deepest = Math.Max(Deepest, position);
    }
}

static class Program
{
    static int failures;

    static void Expect(bool holds, string what)
    {
        if (!holds)
        {
            Console.Error.WriteLine("not so: " + what);
            failures++;
        }
    }

    /// What a contact of these parameters is refused with.
    static void Refused(Palpate.ContactParams contact, Palpate.LoopParams loop, string words, string method,
        params Palpate.Setting[] settings)
    {
        try
        {
            using (new Palpate.Contact(contact, loop, method, settings))
            {
                Expect(false, "it is refused: " + words);
            }
        }
        catch (Palpate.ParameterException error)
        {
            Expect(error.Message.StartsWith(words, StringComparison.Ordinal), error.Message);
        }
    }

    static int Main()
    {
        var loop = Palpate.LoopParams.Default(0.001);
        Expect(loop.ForceLimit == 20.0, "the force limit is 20 N");
        var contact = Palpate.ContactParams.Default(1000.0);
        using (var basic = new Palpate.Contact(contact, loop, "basic"))
        {
            Expect(basic.Step(0.001) == -1.0, "1 mm in 1000 N/m are 1 N");
            Palpate.Output output;
            basic.Step(Palpate.Sample.At(double.NaN), out output);
            Expect(output.Fault == Palpate.Fault.PositionNotFinite, "a position that is no number is refused");
            Expect(output.Phase == Palpate.Phase.Waiting, "and the object waits");
            contact.Stiffness = 2000.0;
            basic.Change(contact, loop, "basic");
        }
        contact.Stiffness = 1000.0;
        // 1 N of the spring, and 0.5 N s/m times 1 m/s of the damper.
        var damping = new Palpate.Setting("damping_n_s_per_m", 0.5);
        using (var damped = new Palpate.Contact(contact, loop, "virtual-damper", damping))
        {
            damped.Step(0.0);
            Expect(Math.Abs(damped.Step(0.001) - -1.5) < 1e-12, "the damping that was set acts");
            damped.Change(contact, loop, "virtual-damper", damping, new Palpate.Setting("prediction", "last-step"));
        }
        Refused(contact, loop, "virtual-damper has no setting \"dampening\"; it has ",
            "virtual-damper", new Palpate.Setting("dampening", 0.5));
        Refused(contact, loop, "damping is -1 N s/m, but must be ",
            "virtual-damper", new Palpate.Setting("damping_n_s_per_m", -1.0));
        Refused(contact, loop, "prediction is \"a guess\", but must be \"last-step\", \"first-order-adaptive-window\", \"extrapolation\" or \"observer\"",
            "virtual-damper", damping, new Palpate.Setting("prediction", "a guess"));
        contact.Stiffness = -1.0;
        Refused(contact, loop, "stiffness is -1 N/m, but must be finite and greater than 0", "basic");

        var device = new HandOnAxis();
        var wall = new Wall { Device = device };
        wall.OnEnable();
        while (Interlocked.Read(ref device.Reads) < 1500)
        {
            Thread.Sleep(1);
        }
        wall.OnDisable();
        Expect(device.Last == 0.0, "the force is taken off at the end");
        // How deep depends on how the machine keeps time: a tick that comes late is a longer period.
        Expect(device.Pushed && device.Deepest > 0.0005, "the device has met the wall, and was pushed back");
        Expect(device.Largest <= 20.0, "no force exceeds the limit");
        Console.WriteLine("Unity: the device rests {0:F6} m in the wall", wall.Penetration);
        return failures == 0 ? 0 : 1;
    }
}
