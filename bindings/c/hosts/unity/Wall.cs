// A wall that a device touches, in a thread of its own: Unity's Update comes at the rate of the display, which
// is too slow for a hand. Give it a device, for instance the driver of a vendor.
//
// License: MIT OR Apache-2.0
using System;
using System.Diagnostics;
using System.Threading;
using UnityEngine;

/// <summary>What a driver gives and takes, along one axis.</summary>
public interface IHapticAxis
{
    /// <summary>Position of the end-point [m].</summary>
    double ReadPosition();

    /// <summary>Force on the device [N].</summary>
    void WriteForce(double force);
}

/// <summary>A wall in a scene: x = 0 of its object is the surface.</summary>
public sealed class Wall : MonoBehaviour
{
    public double Stiffness = 1000.0; // [N/m]
    public double DeviceMass = 0.25; // [kg]
    public double Period = 0.001; // [s]
    public IHapticAxis Device;

    /// <summary>How far the device is in the wall [m], of the last tick.</summary>
    public double Penetration { get { return Volatile.Read(ref penetration); } }

    double penetration;
    volatile bool running;
    Thread thread;

    public void OnEnable()
    {
        var loop = Palpate.LoopParams.Default(Period);
        loop.DeviceMass = DeviceMass;
        // Made here, so that an exception says what is wrong where Unity shows it.
        var contact = new Palpate.Contact(Palpate.ContactParams.Default(Stiffness), loop);
        running = true;
        thread = new Thread(() => Run(contact)) { Priority = System.Threading.ThreadPriority.Highest };
        thread.Start();
    }

    public void OnDisable()
    {
        running = false;
        if (thread != null)
        {
            thread.Join();
        }
    }

    void Run(Palpate.Contact contact)
    {
        try
        {
            using (contact)
            {
                var clock = Stopwatch.StartNew();
                double last = 0.0;
                for (long tick = 0; running; tick++)
                {
                    while (clock.Elapsed.TotalSeconds < tick * Period)
                    {
                        Thread.SpinWait(20);
                    }
                    double now = clock.Elapsed.TotalSeconds;
                    var sample = Palpate.Sample.At(Device.ReadPosition());
                    if (tick > 0)
                    {
                        sample.Elapsed = now - last;
                        sample.HasElapsed = 1;
                    }
                    last = now;
                    Palpate.Output output;
                    Device.WriteForce(contact.Step(sample, out output));
                    Volatile.Write(ref penetration, output.Penetration);
                }
            }
        }
        finally
        {
            Device.WriteForce(0.0);
        }
    }
}
